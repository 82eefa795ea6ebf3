// SPDX-License-Identifier: MIT
//
// A page in a real browser: node browser.mjs CHROMIUM PAGE plots|bare [PICTURE-PREFIX]. Opens it 1280 and
// 400 pixels wide, uses what can be used, and prints "ok - NAME" or "not ok - NAME: WHY" for each thing
// that must hold. Speaks the DevTools protocol over pipes, so it needs nothing but node and Chromium.
import {spawn} from 'node:child_process';
import {mkdtempSync, rmSync, writeFileSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {join, resolve} from 'node:path';
import {pathToFileURL} from 'node:url';

const [, , program, file, kind, prefix] = process.argv;
const plots = kind === 'plots';
const profile = mkdtempSync(join(tmpdir(), 'strata-browser-'));
const browser = spawn(program, ['--headless=new', '--no-sandbox', '--disable-gpu', '--remote-debugging-pipe',
  '--no-first-run', '--disable-background-networking', `--user-data-dir=${profile}`],
{stdio: ['ignore', 'ignore', 'ignore', 'pipe', 'pipe']});
const timer = setTimeout(() => { console.log('not ok - browser: no answer in 90 s'); end(1); }, 90000);
const waiting = new Map(), listeners = [];
let last = 0, failures = 0, pending = '';

/* The browser's helpers write for a moment after it is gone: its folder is removed when it lets one. */
function end(status) {
  clearTimeout(timer);
  const remove = (tries) => {
    try {
      rmSync(profile, {recursive: true, force: true});
      process.exit(status);
    } catch (error) {
      if (tries === 0) {
        console.log(`not ok - browser: ${error.message}`);
        process.exit(1);
      }
      setTimeout(remove, 200, tries - 1);
    }
  };
  if (browser.exitCode !== null || browser.signalCode !== null || browser.pid === undefined) return remove(50);
  browser.on('exit', () => remove(50));
  browser.kill('SIGKILL');
}

browser.on('error', (error) => { console.log(`not ok - browser: ${error.message}`); end(1); });
browser.stdio[4].on('data', (data) => {
  const parts = (pending + data).split('\0');
  pending = parts.pop();
  for (const part of parts) {
    const message = JSON.parse(part);
    if (message.id) waiting.get(message.id)?.(message);
    else listeners.forEach((listener) => listener(message));
  }
});

function send(method, params = {}, sessionId = undefined) {
  const id = ++last;
  browser.stdio[3].write(`${JSON.stringify({id, method, params, sessionId})}\0`);
  return new Promise((done, failed) => waiting.set(id, (message) =>
    (message.error ? failed(new Error(`${method}: ${message.error.message}`)) : done(message.result))));
}

function verdict(name, holds, why) {
  console.log(holds ? `ok - ${name}` : `not ok - ${name}: ${why}`);
  failures += holds ? 0 : 1;
}

const sleep = (ms) => new Promise((done) => { setTimeout(done, ms); });

async function open(width) {
  const {targetId} = await send('Target.createTarget', {url: 'about:blank'});
  const {sessionId} = await send('Target.attachToTarget', {targetId, flatten: true});
  const page = {errors: [], requests: [], send: (method, params) => send(method, params, sessionId)};
  listeners.push((message) => {
    if (message.sessionId !== sessionId) return;
    const {method, params} = message;
    if (method === 'Runtime.exceptionThrown') page.errors.push(params.exceptionDetails.exception?.description ?? 'exception');
    if (method === 'Runtime.consoleAPICalled' && ['error', 'warning', 'assert'].includes(params.type))
      page.errors.push(params.args.map((arg) => arg.value ?? arg.description).join(' '));
    if (method === 'Log.entryAdded' && params.entry.level === 'error') page.errors.push(params.entry.text);
    if (method === 'Network.requestWillBeSent' && !params.request.url.startsWith('data:')) page.requests.push(params.request.url);
  });
  for (const domain of ['Runtime', 'Log', 'Network', 'Page']) await page.send(`${domain}.enable`);
  await page.send('Emulation.setDeviceMetricsOverride', {width, height: 900, deviceScaleFactor: 1, mobile: width < 600});
  page.evaluate = async (expression) => {
    const {result, exceptionDetails} = await page.send('Runtime.evaluate', {expression, returnByValue: true});
    if (exceptionDetails) throw new Error(exceptionDetails.exception?.description ?? exceptionDetails.text);
    return result.value;
  };
  await page.send('Page.navigate', {url: pathToFileURL(resolve(file)).href});
  for (let tries = 0; tries < 150 && (await page.evaluate('document.documentElement?.dataset.ready')) !== 'true'; tries++) await sleep(100);
  return page;
}

async function picture(page, name) {
  if (!prefix) return;
  const {data} = await page.send('Page.captureScreenshot', {captureBeyondViewport: true, format: 'png',
    clip: await page.evaluate('({x: 0, y: 0, width: innerWidth, height: document.documentElement.scrollHeight, scale: 1})')});
  writeFileSync(`${prefix}${name}.png`, Buffer.from(data, 'base64'));
}

const firstColumn = `[...document.querySelectorAll('table')].find((t) => t.textContent.includes('x floor'))`;

async function look(width) {
  const page = await open(width), at = `${width} pixels`;
  const is = async (name, expression, why) => {
    const value = await page.evaluate(expression);
    verdict(`${name}, ${at}`, value === true, `${why ?? expression} gives ${JSON.stringify(value)}`);
  };
  await is('the page is drawn', `document.documentElement.dataset.ready === 'true'`);
  await is('words stand on top', `/^Exact costs [0-9.]+ x floor/.test(document.querySelector('.words li').textContent)`);
  await is('it is as wide as the window', 'document.documentElement.scrollWidth <= innerWidth');
  await is(plots ? 'there are plots' : 'there are none', `(typeof Chart !== 'undefined') === ${plots} &&
    (document.querySelectorAll('canvas').length > 0) === ${plots}`);
  await is('what is missing is said once', `(() => { const said = document.querySelectorAll('.missing');
    return ${plots} ? said.length === 0 : said.length === 1 && said[0].textContent.includes('package libjs-chart.js')
      && said[0].getBoundingClientRect().top < 300; })()`);
  await is('no heading is empty', `[...document.querySelectorAll('h2, h3')].every((h) => h.nextElementSibling
    && !(h.nextElementSibling.tagName <= h.tagName && /^H[23]$/.test(h.nextElementSibling.tagName)))`);
  await is('plots are drawn within it', `[...document.querySelectorAll('canvas')].every((c) =>
    c.clientWidth > 200 && c.clientWidth <= innerWidth && c.getContext('2d').getImageData(0, 0, c.width, c.height).data.some((v) => v > 0))`);
  await is('tables have rows', `${firstColumn}.tBodies[0].rows.length > 5`);
  await is('a heading sorts', `(() => { const t = ${firstColumn}, head = t.tHead.rows[0].cells[2].firstChild; head.click();
    const times = [...t.tBodies[0].rows].map((r) => Number(r.cells[2].textContent));
    return times.every((v, i) => i === 0 || v >= times[i - 1]); })()`);
  await is('and sorts back', `(() => { const t = ${firstColumn}; t.tHead.rows[0].cells[2].firstChild.click();
    const times = [...t.tBodies[0].rows].map((r) => Number(r.cells[2].textContent));
    return times.every((v, i) => i === 0 || v <= times[i - 1]); })()`);
  await is('pictures can be slid', `(() => { const s = document.querySelector('.slider'); if (!s) return false; s.value = '20';
    s.dispatchEvent(new Event('input')); const c = document.querySelector('.compare');
    return c.children[1].style.clipPath.includes('20%') && c.children[0].naturalWidth > 0; })()`);
  await is('pictures can be chosen', `(() => { const s = document.querySelector('select'), shown = new Set();
    for (let i = 0; i < s.options.length; i++) { s.selectedIndex = i; s.dispatchEvent(new Event('change'));
      shown.add(document.querySelector('.compare').children[1].src); }
    return s.options.length < 2 || shown.size > 1; })()`);
  await is('hovering tells settings and passes', `(() => { if (!${plots}) return true;
    const chart = Chart.getChart(document.querySelector('canvas')), set = chart.data.datasets.findIndex((d) => d.data.length);
    chart.tooltip.setActiveElements([{datasetIndex: set, index: 0}], {x: 0, y: 0}); chart.update();
    return chart.tooltip.body[0].lines.length > 3; })()`);
  await page.evaluate(`(() => { for (const d of document.querySelectorAll('details')) d.open = true; })()`);
  await is('it stays so with all opened', 'document.documentElement.scrollWidth <= innerWidth');
  await page.evaluate(`(() => { for (const d of document.querySelectorAll('details')) d.open = false; })()`);
  await sleep(200);
  await picture(page, String(width));
  await is('texts of the results are no markup', `!document.querySelector('main script') && typeof window.broken === 'undefined'`);
  verdict(`no errors on the console, ${at}`, page.errors.length === 0, page.errors.join('; '));
  verdict(`nothing is fetched, ${at}`, page.requests.length === 1, page.requests.join(' '));
}

try {
  await look(1280);
  await look(400);
} catch (error) {
  verdict('browser', false, error.message);
}
end(failures ? 1 : 0);
