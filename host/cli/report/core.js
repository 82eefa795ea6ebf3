// SPDX-License-Identifier: MIT
//
// The report's parts: elements, figures as text, tables that can be sorted and copied. Texts of the
// results reach the page as text nodes alone, never as markup.
'use strict';
const root = document.documentElement;
root.dataset.errors = '0';
window.addEventListener('error', () => { root.dataset.errors = String(Number(root.dataset.errors) + 1); });

function element(tag, properties, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(properties || {})) {
    if (name.startsWith('on')) made.addEventListener(name.slice(2), value);
    else if (name === 'class') made.className = value;
    else made.setAttribute(name, value);
  }
  made.append(...children.filter((child) => child !== null && child !== undefined));
  return made;
}

function readJson(id) { return JSON.parse(document.getElementById(id).textContent); }

function isNumber(value) { return typeof value === 'number' && Number.isFinite(value); }

// Three significant digits; what is not known is a dash.
function figure(value) {
  if (!isNumber(value)) return '\u2013';
  if (value === 0) return '0';
  const size = Math.abs(value);
  return size >= 1e5 || size < 1e-3 ? value.toExponential(2) : Number(value.toPrecision(3)).toString();
}

function whole(value) { return isNumber(value) ? value.toLocaleString('en') : '\u2013'; }

function bytes(value) {
  if (!isNumber(value)) return '\u2013';
  const units = ['B', 'kB', 'MB', 'GB'];
  let unit = 0;
  for (; value >= 1000 && unit < 3; unit++) value /= 1000;
  return `${Number(value.toPrecision(3))} ${units[unit]}`;
}

// Without the clipboard (a file, an old browser) the text is shown to be copied by hand.
async function copyText(text, button) {
  const before = button.textContent;
  try {
    await navigator.clipboard.writeText(text);
    button.textContent = 'copied';
    setTimeout(() => { button.textContent = before; }, 1200);
  } catch (refused) {
    window.prompt('Copy this:', text);
  }
}

function copyButton(label, text) {
  const button = element('button', {class: 'copy', type: 'button'}, label);
  button.addEventListener('click', () => copyText(typeof text === 'function' ? text() : text, button));
  return button;
}

function compareValues(a, b) {
  const left = isNumber(a), right = isNumber(b);
  if (left && right) return a - b;
  if (left !== right) return left ? -1 : 1; // what is not known comes last
  return String(a ?? '').localeCompare(String(b ?? ''));
}

// columns: {title, value: row -> number or text, show: value -> text, text: 1 for texts, copy: 1 for
// a button in its place}. rowClass: row -> class names.
function table(columns, rows, rowClass) {
  const body = element('tbody', {});
  let order = rows.slice(), sorted = -1, down = 1;
  const cell = (column, row) => {
    const value = column.value(row);
    if (column.copy) return element('td', {class: 'text'}, copyButton('copy', String(value ?? '')));
    return element('td', {class: column.text ? 'text' : ''},
      column.show ? column.show(value) : String(value ?? ''));
  };
  const draw = () => body.replaceChildren(...order.map((row) =>
    element('tr', {class: rowClass ? rowClass(row) : ''}, ...columns.map((column) => cell(column, row)))));
  const sortBy = (index) => {
    down = sorted === index ? -down : 1;
    sorted = index;
    order = rows.slice().sort((a, b) => down * compareValues(columns[index].value(a), columns[index].value(b)));
    heads.forEach((head, i) => head.setAttribute('aria-sort',
      i === index ? (down > 0 ? 'ascending' : 'descending') : 'none'));
    draw();
  };
  const heads = columns.map((column, index) => element('th', {class: column.text ? 'text' : '', scope: 'col'},
    element('button', {type: 'button', onclick: () => sortBy(index)}, column.title)));
  const asText = () => [columns.map((column) => column.title), ...order.map((row) =>
    columns.map((column) => String(column.value(row) ?? '').replace(/[\t\n]/g, ' ')))]
    .map((line) => line.join('\t')).join('\n');
  draw();
  return element('div', {},
    element('div', {class: 'tools'}, copyButton('Copy table', asText),
      element('span', {class: 'note'}, 'sorted by a click on a heading')),
    element('div', {class: 'scroll', tabindex: '0'},
      element('table', {}, element('thead', {}, element('tr', {}, ...heads)), body)));
}
