// SPDX-License-Identifier: MIT
//
// The report's page: what was found in words, and for each scene and size plots, pictures and tables.
const results = readJson('results'), pictures = readJson('pictures');

const errorOf = (c) => (c.error ? c.error.max : null);
const boundOf = (c) => (c.bound ? c.bound.max : null);
const isFloor = (c) => c.name === 'floor';
const measured = (one) => one.configurations.filter((c) => c.state === 'measured');
const shownCost = (one, c) => (isNumber(one.floor_ms) ? c.x_floor : c.ms);
const costTitle = (one) => (isNumber(one.floor_ms) ? 'time, x floor' : 'time, ms');

// Of the last frame, in the usual pace of the device, as all other times are.
function passesOf(c) {
  const pace = c.pace && c.pace.length ? c.pace[c.pace.length - 1] : 1;
  const usual = (ms) => (isNumber(ms) ? ms / pace : ms);
  return (c.passes || []).map((pass) => ({...pass, gpu_ms: usual(pass.gpu_ms), cpu_ms: usual(pass.cpu_ms)}));
}

// What hovering a point says: settings, figures, passes.
function pointLines(c) {
  const passes = passesOf(c).map((pass) =>
    `  ${pass.technique || 'host'}: ${pass.label} ${figure(isNumber(pass.gpu_ms) ? pass.gpu_ms : pass.cpu_ms)} ms`);
  return [c.name, `${figure(c.ms)} ms (MAD ${figure(c.mad_ms)}), ${figure(c.x_floor)} x floor`,
    `measured ${figure(errorOf(c))}, certified ${figure(boundOf(c))}`, ...passes.slice(0, 14),
    ...(passes.length > 14 ? [`  and ${passes.length - 14} more`] : [])];
}

function kindOf(c) {
  if (c.exact) return 'exact';
  if (c.order === 'approximate') return 'approximate';
  return c.payload === 'float' ? 'nearest' : 'payload';
}

const KINDS = {exact: 'exact', nearest: 'nearest k, or ends early', payload: 'rounded payload', approximate: 'approximate'};

function onPlot(error) { return Math.max(error, NOTHING); }

// Points of each kind at (x, error), and their certificates above them.
function errorPlot(one, xOf, x) {
  const all = measured(one).filter((c) => isNumber(xOf(c)) && xOf(c) > 0);
  const point = (c, error) => ({x: xOf(c), y: onPlot(error), lines: pointLines(c)});
  const sets = Object.keys(KINDS).map((kind) => ({
    label: `${KINDS[kind]}, measured`,
    data: all.filter((c) => kindOf(c) === kind && isNumber(errorOf(c))).map((c) => point(c, errorOf(c))),
    backgroundColor: COLORS[kind],
    pointRadius: 5,
  })).filter((set) => set.data.length);
  sets.push({
    label: 'certified',
    data: all.filter((c) => isNumber(boundOf(c))).map((c) => point(c, boundOf(c))),
    pointStyle: 'triangle',
    borderColor: '#5a6470',
    backgroundColor: 'transparent',
    pointRadius: 4,
  });
  return {sets, x, y: axis('largest error, linear', {log: true, zero: true, min: NOTHING})};
}

function paretoPlot(one) {
  const {sets, x, y} = errorPlot(one, (c) => shownCost(one, c), axis(costTitle(one), {log: true, fine: true}));
  const front = measured(one).filter((c) => c.front).sort((a, b) => a.ms - b.ms);
  sets.push({
    type: 'line',
    label: 'Pareto front, measured',
    data: front.map((c) => ({x: shownCost(one, c), y: onPlot(errorOf(c)), lines: pointLines(c)})),
    borderColor: COLORS.line,
    borderWidth: 2,
    stepped: 'before',
    pointRadius: 0,
  });
  return plot('scatter', sets, x, y);
}

function memoryPlot(one) {
  const {sets, x, y} = errorPlot(one, (c) => c.memory, axis('device memory of the techniques', {log: true, show: bytes}));
  return plot('scatter', sets, x, y);
}

// ---- k

// Time against how many fragments are kept, a series for each combination that has such a knob.
function costOfK(one) {
  const series = new Map();
  for (const c of measured(one)) {
    const others = c.settings.filter((setting) => !/\.(k|layers)=/.test(setting));
    if (!(c.keeps > 0) || others.length) continue;
    if (!series.has(c.use)) series.set(c.use, []);
    series.get(c.use).push({x: c.keeps, y: c.ms, lines: pointLines(c)});
  }
  const list = [...series].filter(([, points]) => points.length > 2)
    .map(([use, points]) => ({name: use.replaceAll(',', ' + '), points}));
  return list.length ? plotted('Time against k', () => growthPlot(list, 'fragments kept a pixel (k)', 'ms')) : [];
}

// Pairs [n, pixels] into at most 48 bins of even width.
function bins(pairs, largest) {
  const width = Math.max(1, Math.ceil((largest + 1) / 48));
  const counts = new Array(Math.ceil((largest + 1) / width)).fill(0);
  for (const [n, pixels] of pairs) counts[Math.floor(n / width)] += pixels;
  return {width, counts};
}

function complexityPlot(complexity) {
  const largest = complexity.held.at(-1)[0];
  const held = bins(complexity.held, largest), needed = bins(complexity.needed, largest);
  const labels = held.counts.map((_, i) => (held.width === 1 ? String(i) : `${i * held.width}\u2013${(i + 1) * held.width - 1}`));
  const x = {title: {display: true, text: 'fragments'}, ticks: {maxRotation: 0, autoSkip: true}};
  return plot('bar', [
    {label: 'fragments that pixels hold', data: held.counts, backgroundColor: COLORS.exact},
    {label: 'nearest fragments that do for 1/255', data: needed.counts, backgroundColor: COLORS.nearest},
  ], x, axis('pixels', {log: true, min: 0.8}), labels);
}

function shareUpTo(pairs, k) {
  const total = pairs.reduce((sum, pair) => sum + pair[1], 0);
  return pairs.reduce((sum, [n, pixels]) => sum + (n <= k ? pixels : 0), 0) / total;
}

function complexitySection(one) {
  const complexity = one.complexity;
  if (!complexity || !complexity.held.length) return [];
  const largest = complexity.held.at(-1)[0], rows = [];
  for (let k = 1; k < largest; k *= 2) rows.push(k);
  rows.push(largest);
  const percent = (value) => `${Number((100 * value).toPrecision(4))} %`;
  return [...plotted('Depth complexity', () => complexityPlot(complexity)),
    element('h3', {}, 'The k that pixels need'),
    table([
      {title: 'k', value: (k) => k, show: whole},
      {title: 'pixels it is exact for', value: (k) => shareUpTo(complexity.held, k), show: percent},
      {title: 'pixels it does for, to 1/255', value: (k) => shareUpTo(complexity.needed, k), show: percent},
    ], rows)];
}

// ---- pictures

function mapFigure(uri, text) {
  return element('figure', {}, element('img', {src: uri, alt: text, loading: 'lazy'}), element('figcaption', {}, text));
}

function pictureSection(one, shown) {
  if (!shown || !shown.exact || !shown.others.length) return [];
  const under = element('img', {src: shown.exact, alt: 'the exact image'});
  const over = element('img', {alt: ''}), maps = element('div', {class: 'maps'});
  const slider = element('input', {type: 'range', min: '0', max: '100', value: '50', class: 'slider',
    'aria-label': 'where one picture gives way to the other'});
  const choice = element('select', {'aria-label': 'configuration'}, ...shown.others.map((other, i) =>
    element('option', {value: String(i)}, one.configurations[other.at].name)));
  const slide = () => { over.style.clipPath = `inset(0 0 0 ${slider.value}%)`; };
  const show = () => {
    const other = shown.others[Number(choice.value)], c = one.configurations[other.at];
    over.src = other.kinds.color;
    over.alt = c.name;
    maps.replaceChildren(
      mapFigure(other.kinds.heat, `error: black 1e-7 and below, a step a decade, white 1 and above; at most ${figure(errorOf(c))}`),
      mapFigure(other.kinds.flip, `FLIP: black 0 to white 1; mean ${figure(c.error.flip.mean)}`));
  };
  slider.addEventListener('input', slide);
  choice.addEventListener('change', show);
  show();
  slide();
  return [element('h3', {}, 'Side by side'),
    element('div', {class: 'tools'}, element('span', {}, 'left: exact; right:'), choice),
    element('div', {class: 'compare'}, under, over), slider, maps,
    shown.left_out ? element('p', {class: 'note'}, `${shown.left_out} more are in the folder pictures.`) : null];
}

// ---- tables

function figuresTable(one) {
  const error = (key) => (c) => (c.error ? c.error[key] : null);
  return table([
    {title: 'configuration', value: (c) => c.name, text: 1},
    {title: 'x floor', value: (c) => c.x_floor, show: figure},
    {title: 'ms', value: (c) => c.ms, show: figure},
    {title: 'MAD', value: (c) => c.mad_ms, show: figure},
    {title: 'CPU ms', value: (c) => c.cpu_frame_ms, show: figure},
    {title: 'max error', value: errorOf, show: figure},
    {title: 'certified', value: boundOf, show: figure},
    {title: 'uncertified pixels', value: error('uncertified_pixels'), show: whole},
    {title: 'RMSE', value: error('rmse'), show: figure},
    {title: 'PSNR', value: error('psnr'), show: figure},
    {title: 'FLIP', value: (c) => (c.error ? c.error.flip.mean : null), show: figure},
    {title: 'memory', value: (c) => c.memory, show: bytes},
    {title: 'exact', value: (c) => (c.exact ? 'yes' : ''), text: 1},
    {title: 'front', value: (c) => (c.front ? 'yes' : ''), text: 1},
    {title: 'command', value: (c) => c.command, copy: 1, text: 1},
  ], measured(one), (c) => `${c.front ? 'front' : ''} ${c.exact ? 'exact' : ''}`);
}

function passesTable(one) {
  const rows = measured(one).flatMap((c) => passesOf(c).map((pass) => ({c, pass})));
  return table([
    {title: 'configuration', value: (row) => row.c.name, text: 1},
    {title: 'technique', value: (row) => row.pass.technique, text: 1},
    {title: 'pass', value: (row) => row.pass.label, text: 1},
    {title: 'GPU ms', value: (row) => row.pass.gpu_ms, show: figure},
    {title: 'CPU ms', value: (row) => row.pass.cpu_ms, show: figure},
  ], rows);
}

function notMeasured(one) {
  const rows = one.configurations.filter((c) => c.state !== 'measured')
    .map((c) => ({name: c.name, state: c.state, reason: c.reason}))
    .concat(one.refused.map((c) => ({name: [c.use, ...c.settings].join(' '), state: 'not planned', reason: c.reason})));
  if (!rows.length) return null;
  return element('details', {}, element('summary', {}, `Not measured (${rows.length})`), table([
    {title: 'configuration', value: (row) => row.name, text: 1},
    {title: 'state', value: (row) => row.state, text: 1},
    {title: 'why', value: (row) => row.reason, text: 1},
  ], rows));
}

// ---- the page

function words(lines) { return element('ul', {class: 'words'}, ...lines.map((line) => element('li', {}, line))); }

// How far the device's own speed went up and down, and that it is not in the figures.
function paceNote(one) {
  const paces = measured(one).flatMap((c) => c.pace || []);
  if (!isNumber(one.pace_ms) || !paces.length) return null;
  const share = (x) => x.toFixed(2);
  return element('p', {class: 'note'}, `While this was measured the floor took ${share(Math.min(...paces))} to ${share(Math.max(...paces))} `
    + 'times as long as usual; all times are divided by what it took beside them.');
}

function caseSection(one, index) {
  const fragments = one.fragments || {};
  return [element('h2', {id: `case-${index}`}, `${one.scene}, ${one.size[0]} \u00d7 ${one.size[1]}`),
    words(one.words || []),
    element('p', {class: 'note'}, `${whole(fragments.total)} fragments, ${whole(fragments.max_per_pixel)} in the deepest pixel; floor ${figure(one.floor_ms)} ms; exact image by ${one.reference.name || 'the plan'}.`),
    ...plotted('Time against error', () => paretoPlot(one)),
    paceNote(one),
    element('p', {class: 'note'}, `The floor is the time to blend all fragments once, unordered and unlit.${havePlots ? ' An error of 0 is drawn at the lower edge. Lower left is better.' : ''}`),
    ...plotted('Memory against error', () => memoryPlot(one)),
    ...costOfK(one), ...complexitySection(one), ...pictureSection(one, pictures[index]),
    element('h3', {}, 'All configurations'), figuresTable(one),
    element('details', {}, element('summary', {}, 'Times of passes, last frame'), passesTable(one)), notMeasured(one)];
}

const GROWTH = {
  fragments: (one) => (one.fragments || {}).total,
  pixels: (one) => one.size[0] * one.size[1],
  'fragments a pixel': (one) => ((one.fragments || {}).total || 0) / (one.size[0] * one.size[1]),
};

// Configurations that every case has, those on a front first.
function growthSeries(xOf) {
  const cases = results.cases, byName = new Map();
  cases.forEach((one) => measured(one).forEach((c) => {
    if (!byName.has(c.name)) byName.set(c.name, {name: c.name, points: [], weight: 0});
    const series = byName.get(c.name);
    series.points.push({x: xOf(one), y: c.ms, lines: [one.scene, ...pointLines(c)]});
    series.weight += isFloor(c) ? 100 : c.exact + 2 * c.front;
  }));
  return [...byName.values()].filter((series) => series.points.length === cases.length)
    .sort((a, b) => b.weight - a.weight).slice(0, 8);
}

function growthSection() {
  if (results.cases.length < 2 || !havePlots) return [];
  const parts = [element('h2', {}, 'How costs grow')];
  for (const [title, xOf] of Object.entries(GROWTH)) {
    const values = new Set(results.cases.map(xOf));
    if (values.size < 2 || [...values].some((value) => !(value > 0))) continue;
    parts.push(...plotted(`Time against ${title}`, () => growthPlot(growthSeries(xOf), title, 'ms')));
  }
  return parts;
}

function machineSection() {
  const device = results.device || {}, machine = results.machine || {}, request = results.request || {};
  const facts = [['device', device.name], ['backend', device.backend], ['driver', device.driver],
    ['processor', `${machine.processor}, ${machine.cores} cores`], ['system', machine.system],
    ['Strata', results.strata], ['samples', request.samples], ['frames', `${request.frames} of each configuration that may matter, the camera turned by a degree a frame; medians`]];
  return [element('h2', {}, 'Machine and driver'), element('dl', {}, ...facts.flatMap(([name, value]) =>
    [element('dt', {}, name), element('dd', {}, String(value ?? '\u2013'))]))];
}

function page() {
  const violations = results.violations || [];
  const links = results.cases.length > 1 ? element('ul', {}, ...results.cases.map((one, index) => element('li', {},
    element('a', {href: `#case-${index}`}, `${one.scene}, ${one.size[0]} \u00d7 ${one.size[1]}`), `: ${(one.words || [])[0] || ''}`))) : null;
  document.getElementById('page').replaceChildren(...[
    element('h1', {}, 'What accuracy costs'), ...violations.map((line) => element('p', {class: 'bad'}, `Does not hold: ${line}`)),
    noPlots(), links, ...results.cases.flatMap(caseSection), ...growthSection(), ...machineSection()].filter(Boolean));
}

page();
requestAnimationFrame(() => {
  root.dataset.overflow = String(root.scrollWidth > root.clientWidth);
  root.dataset.ready = 'true';
});
