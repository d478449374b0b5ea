// A chart over time: its levels, its times, and a mark at the time that is shown.

const chart = element('chart');
const chartPen = chart.getContext('2d');
const chartView = { wide: 0, high: 0, left: 34, right: 8, top: 16, bottom: 34, whole: 1, low: 0, most: 1 };

// 1, 2 or 5 times a power of ten, so that about so many parts make up the whole.
function rounded(whole, parts) {
  const wanted = Math.max(whole / parts, 1e-3);
  const power = 10 ** Math.floor(Math.log10(wanted));
  return [1, 2, 5, 10].map((factor) => factor * power).find((step) => step >= wanted - 1e-9);
}

function fitChart() {
  chartView.wide = Math.max(element('chart-room').clientWidth, 120);
  // What is left below the table, where that stands beside the arena.
  const above = element('chart-room').getBoundingClientRect().top + scrollY;
  const wide = matchMedia('(min-width: 1081px)').matches;
  chartView.high = wide ? Math.round(Math.min(Math.max(innerHeight - above - 24, 150), 300)) : 190;
  chart.width = Math.round(chartView.wide * view.ratio);
  chart.height = Math.round(chartView.high * view.ratio);
  chart.style.height = `${chartView.high}px`;
}

const chartX = (seconds) => {
  const { wide, left, right, whole } = chartView;
  return left + (seconds / whole) * (wide - left - right);
};
const chartBase = () => chartView.high - chartView.bottom;
const chartY = (value) => {
  const { top, low, most } = chartView;
  return chartBase() - ((value - low) / (most - low)) * (chartBase() - top);
};

// Clears the chart and draws its levels, `step` apart.
function drawLevels(step) {
  const p = chartPen;
  const { wide, high, left, right, low, most } = chartView;
  p.setTransform(view.ratio, 0, 0, view.ratio, 0, 0);
  p.clearRect(0, 0, wide, high);
  p.font = `11px ${FONT}`;
  p.textBaseline = 'middle';
  p.textAlign = 'right';
  p.lineWidth = 1;
  for (let value = low; value <= most + 1e-9 * step; value += step) {
    p.strokeStyle = '#e1e2e6';
    p.beginPath();
    p.moveTo(left, Math.round(chartY(value)) + 0.5);
    p.lineTo(wide - right, Math.round(chartY(value)) + 0.5);
    p.stroke();
    p.fillStyle = SOFT_INK;
    const label = Math.abs(value) < 1e6 ? Number(value.toPrecision(6)) : value.toExponential(1).replace('+', '');
    p.fillText(label, left - 6, chartY(value));
  }
}

function drawTimes() {
  const p = chartPen;
  const { wide, left, right, whole } = chartView;
  const base = chartBase();
  p.fillStyle = SOFT_INK;
  const unit = whole >= 600 ? 60 : 1;
  const tick = rounded(whole / unit, 7) * unit;
  for (let seconds = 0; seconds <= whole + 1e-9; seconds += tick) {
    // The outermost stay within the chart.
    p.textAlign = seconds > 0.97 * whole ? 'right' : 'center';
    p.fillText(Number((seconds / unit).toFixed(6)), chartX(seconds) + (p.textAlign === 'right' ? right - 2 : 0), base + 11);
  }
  p.textAlign = 'center';
  p.fillText(unit === 60 ? 'minutes' : 'seconds', (left + wide - right) / 2, base + 26);
}

function drawNow(when) {
  const p = chartPen;
  const { top } = chartView;
  const x = chartX(when);
  p.strokeStyle = INK;
  p.lineWidth = 1.6;
  p.beginPath();
  p.moveTo(x, top - 4);
  p.lineTo(x, chartBase());
  p.stroke();
  p.fillStyle = INK;
  p.beginPath();
  p.moveTo(x - 4, top - 8);
  p.lineTo(x + 4, top - 8);
  p.lineTo(x, top - 2);
  p.fill();
}

