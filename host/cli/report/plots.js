// SPDX-License-Identifier: MIT
//
// The report's plots, drawn by Chart.js where it was there when Strata was built.
const havePlots = typeof Chart !== 'undefined';
const NOTHING = 1e-8; // where an error of 0 stands on a logarithmic axis
const COLORS = {exact: '#0072b2', nearest: '#d55e00', approximate: '#cc79a7', payload: '#009e73', line: '#e69f00'};
const SERIES = ['#0072b2', '#d55e00', '#009e73', '#cc79a7', '#e69f00', '#56b4e9', '#6b4c9a', '#1b1f24'];

if (havePlots) {
  Chart.defaults.animation = false;
  Chart.defaults.maintainAspectRatio = false;
  Chart.defaults.font.family = 'system-ui, sans-serif';
  Chart.defaults.plugins.legend.position = 'bottom';
  Chart.defaults.plugins.legend.labels.boxWidth = 12;
}

function isPowerOf(base, value) {
  const power = Math.log(value) / Math.log(base);
  return Math.abs(power - Math.round(power)) < 1e-6;
}

function axis(title, settings) {
  const log = settings && settings.log;
  return {
    type: log ? 'logarithmic' : 'linear',
    title: {display: true, text: title},
    min: settings ? settings.min : undefined,
    max: settings ? settings.max : undefined,
    ticks: {
      maxRotation: 0,
      autoSkip: true,
      callback: (value) => {
        if (settings && settings.zero && value <= NOTHING * 1.01) return '0';
        if (log && !isPowerOf(10, value) && !(settings.fine && [2, 5].includes(Number(value.toExponential(0)[0]))))
          return null;
        return settings && settings.show ? settings.show(value) : log && (value < 1e-3 || value > 1e4)
          ? value.toExponential(0) : String(Number(value.toPrecision(3)));
      },
    },
  };
}

// datasets as Chart.js takes them; a point's `lines` are what hovering shows.
function plot(type, datasets, x, y, labels) {
  const canvas = element('canvas', {role: 'img', 'aria-label': `${y.title.text} against ${x.title.text}`});
  const box = element('div', {class: 'plot'}, canvas);
  new Chart(canvas, {
    type,
    data: {labels, datasets},
    options: {
      scales: {x, y},
      interaction: {mode: 'nearest', intersect: type !== 'bar'},
      plugins: {tooltip: {callbacks: {
        title: () => '',
        label: (item) => item.raw.lines || `${item.dataset.label}: ${whole(item.parsed.y)}`,
      }}},
    },
  });
  return box;
}

// Without the library nothing, which noPlots() says once for all.
function plotted(title, make) { return havePlots ? [element('h3', {}, title), make()] : []; }

function noPlots() {
  if (havePlots) return null;
  return element('p', {class: 'note missing'}, 'There are no plots: Chart.js, which draws them, was missing when Strata was built (package libjs-chart.js). The tables have all figures; strata sweep --resume of a Strata that has it writes this report anew, with plots.');
}

// Slope of a line through the logarithms: 1 = grows in proportion.
function slope(points) {
  const logs = points.map((point) => [Math.log(point.x), Math.log(point.y)]);
  const mean = (index) => logs.reduce((sum, log) => sum + log[index], 0) / logs.length;
  const mx = mean(0), my = mean(1);
  const over = logs.reduce((sum, log) => sum + (log[0] - mx) * (log[1] - my), 0);
  const under = logs.reduce((sum, log) => sum + (log[0] - mx) ** 2, 0);
  return under > 0 ? over / under : NaN;
}

// series: [{name, points: [{x, y, lines}]}], with slopes in the legend.
function growthPlot(series, xTitle, yTitle) {
  return plot('line', series.map((one, index) => ({
    label: `${one.name} (slope ${figure(slope(one.points))})`,
    data: one.points.slice().sort((a, b) => a.x - b.x),
    borderColor: SERIES[index % SERIES.length],
    backgroundColor: SERIES[index % SERIES.length],
    borderWidth: 2,
    pointRadius: 4,
  })), axis(xTitle, {log: true, fine: true}), axis(yTitle, {log: true, fine: true}));
}
