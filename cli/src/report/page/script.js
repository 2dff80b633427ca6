// What a page can do where scripts run: values under the pointer, in all charts of one axis; zoom by dragging; tables that sort and copy.
// Without it the page says the same.
'use strict';
(() => {
  const SHORTEST_DRAG = 8, INTERVALS = 6;
  const make = (parent, name, attributes, text) => {
    const element = document.createElementNS('http://www.w3.org/2000/svg', name);
    Object.entries(attributes).forEach(([key, value]) => element.setAttribute(key, value));
    if (text !== undefined) element.textContent = text;
    return parent.appendChild(element);
  };
  const digits = value => String(Number(value.toPrecision(4))).replace('-', '\u2212');

  // An axis: values to shares of its length and back, and the part of it that is shown.
  const axis = (text, tens) => {
    const [from, to, scale] = text.split(' '), power = 10 ** tens, log = scale === 'log';
    const forth = log ? Math.log : value => value, back = log ? Math.exp : value => value;
    const low = forth(Number(from)), high = forth(Number(to));
    return { scale, power, shown: [0, 1], share: value => (forth(value) - low) / (high - low), value: share => back(low + share * (high - low)) };
  };
  const ticks = one => {
    const [from, to] = one.shown.map(one.value), rough = (to - from) / INTERVALS, decade = 10 ** Math.floor(Math.log10(rough));
    const step = [1, 2, 5, 10].map(factor => factor * decade).find(step => step >= rough);
    const found = [];
    for (let at = Math.ceil(from / step - 1e-9); at * step <= to + 1e-9 * step; at++) found.push(Number((at * step).toPrecision(12)));
    return found;
  };
  const points = path => (path.getAttribute('d').match(/[ML][^MLh]+/g) || []).map(text => text.slice(1).split(' ').map(Number));

  const charts = [...document.querySelectorAll('svg.plot')].map(svg => {
    const panels = [...svg.querySelectorAll('g.panel')].map(group => {
      const [left, top, right, bottom] = group.dataset.frame.split(' ').map(Number);
      const tens = group.dataset.tens.split(' ').map(Number);
      const series = [...group.querySelectorAll('.items [data-name]')].map(path => {
        const along = points(path);
        return { name: path.dataset.name, along, forward: along.every((point, n) => n === 0 || point[0] >= along[n - 1][0]) };
      }).filter(one => one.along.length);
      return { group, left, top, right, bottom, series, tens, y: axis(group.dataset.y, tens[1]), label: group.dataset.yLabel, items: group.querySelector('.items') };
    });
    if (!panels.length || panels[0].group.dataset.x.endsWith('categories')) return null;
    const x = axis(panels[0].group.dataset.x, panels[0].tens[0]), label = panels[0].group.dataset.xLabel;
    const holder = document.createElement('div'), readout = document.createElement('output');
    holder.className = 'chart';
    readout.className = 'readout';
    svg.replaceWith(holder);
    holder.append(svg, readout);
    const loop = panels.every(panel => panel.series.length && panel.series.every(one => !one.forward));
    return { svg, panels, x, label, readout, loop, key: loop || !label ? null : label };
  }).filter(Boolean);
  if (charts.length) {
    const note = document.createElement('p');
    note.className = 'soft tools';
    note.textContent = 'Charts: values under the pointer; drag to zoom, double-click to see all.';
    charts[0].svg.closest('.plots').before(note);
  }

  const scaled = (one, share) => (share - one.shown[0]) / (one.shown[1] - one.shown[0]);
  const place = (panel, one, share) => one === panel.y
    ? panel.bottom - (panel.bottom - panel.top) * scaled(one, share)
    : panel.left + (panel.right - panel.left) * scaled(one, share);

  // Shows the part of the axes that is wanted; strokes keep their width.
  const draw = chart => chart.panels.forEach((panel, index) => {
    const whole = [chart.x, panel.y].every(one => one.shown[0] === 0 && one.shown[1] === 1);
    const { left, right, top, bottom } = panel;
    const sx = 1 / (chart.x.shown[1] - chart.x.shown[0]), sy = 1 / (panel.y.shown[1] - panel.y.shown[0]);
    const tx = left - sx * (left + chart.x.shown[0] * (right - left)), ty = bottom - sy * (bottom - panel.y.shown[0] * (bottom - top));
    panel.items.setAttribute('transform', whole ? '' : `matrix(${sx} 0 0 ${sy} ${tx} ${ty})`);
    panel.group.classList.toggle('zoomed', !whole);
    panel.group.querySelector('.ticks')?.remove();
    if (whole) return;
    const group = make(panel.group, 'g', { class: 'ticks' });
    ticks(chart.x).forEach(value => {
      const at = place(panel, chart.x, chart.x.share(value)).toFixed(1);
      make(group, 'path', { class: 'grid', d: `M${at} ${top}V${bottom}` });
      if (index === chart.panels.length - 1) make(group, 'text', { 'text-anchor': 'middle', x: at, y: bottom + 14 }, digits(value / chart.x.power));
    });
    ticks(panel.y).forEach(value => {
      const at = place(panel, panel.y, panel.y.share(value));
      make(group, 'path', { class: 'grid', d: `M${left} ${at.toFixed(1)}H${right}` });
      make(group, 'text', { 'text-anchor': 'end', x: left - 5, y: (at + 3.8).toFixed(1) }, digits(value / panel.y.power));
    });
    panel.group.insertBefore(group, panel.items.parentNode);
  });
  const linked = chart => chart.key ? charts.filter(other => other.key === chart.key) : [chart];
  const zoom = (chart, range) => linked(chart).forEach(other => {
    const shares = range.map(value => Math.min(1, Math.max(0, other.x.share(value))));
    if (shares[1] - shares[0] > 1e-6) other.x.shown = shares;
    draw(other);
  });
  const all = chart => linked(chart).forEach(other => {
    [other.x, ...other.panels.map(panel => panel.y)].forEach(one => { one.shown = [0, 1]; });
    draw(other);
  });

  // Where the pointer is: in which panel, and at which shares of its axes.
  const where = (chart, event) => {
    const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(chart.svg.getScreenCTM().inverse());
    const panel = chart.panels.find(one => at.x >= one.left && at.x <= one.right && at.y >= one.top && at.y <= one.bottom);
    if (!panel) return null;
    const along = (one, share) => one.shown[0] + share * (one.shown[1] - one.shown[0]);
    return { at, panel, x: along(chart.x, (at.x - panel.left) / (panel.right - panel.left)),
             y: along(panel.y, (panel.bottom - at.y) / (panel.bottom - panel.top)) };
  };
  const height = (panel, one, share) => {
    const x = panel.left + share * (panel.right - panel.left), next = one.along.findIndex(point => point[0] >= x);
    if (next < 0 || (next === 0 && one.along[0][0] - x > 1)) return null;
    const [b, a] = [one.along[next], one.along[Math.max(0, next - 1)]];
    return b[0] === a[0] ? b[1] : a[1] + (x - a[0]) / (b[0] - a[0]) * (b[1] - a[1]);
  };
  const yValue = (panel, at) => digits(panel.y.value((panel.bottom - at) / (panel.bottom - panel.top)));
  const clear = chart => {
    chart.svg.querySelectorAll('.cursor').forEach(line => line.remove());
    chart.readout.textContent = '';
  };
  const split = label => { const [name, unit] = label.split(/, (?=[^,]*$)/); return [name, unit ? ` ${unit}` : '']; };
  const show = (chart, share) => {
    clear(chart);
    if (share < chart.x.shown[0] - 1e-9 || share > chart.x.shown[1] + 1e-9) return;
    const said = [];
    chart.panels.forEach(panel => {
      const x = place(panel, chart.x, share).toFixed(1), seen = new Set();
      make(panel.group, 'path', { class: 'cursor', d: `M${x} ${panel.top}V${panel.bottom}` });
      panel.series.filter(one => one.forward).forEach(one => {
        const at = height(panel, one, share), name = one.name || split(panel.label)[0];
        if (at !== null && !seen.has(name)) said.push(`${name} ${yValue(panel, at)}`);
        seen.add(name);
      });
    });
    const [name, unit] = split(chart.label);
    chart.readout.textContent = `${name} ${digits(chart.x.value(share))}${unit}: ${said.join(', ')}`;
  };
  const nearest = (chart, found) => {
    clear(chart);
    let best = null;
    const { panel } = found, x = panel.left + found.x * (panel.right - panel.left), y = panel.bottom - found.y * (panel.bottom - panel.top);
    panel.series.forEach(one => one.along.forEach(point => {
      const distance = (point[0] - x) ** 2 + (point[1] - y) ** 2;
      if (!best || distance < best.distance) best = { distance, point, name: one.name };
    }));
    if (!best) return;
    const share = (best.point[0] - panel.left) / (panel.right - panel.left), [name, unit] = split(chart.label);
    const own = best.name ? `${best.name}: ` : '';
    chart.readout.textContent = `${own}${name} ${digits(chart.x.value(share))}${unit}, ${split(panel.label)[0]} ${yValue(panel, best.point[1])}`;
  };

  charts.forEach(chart => {
    let start = null, frame = null;
    const ends = event => {
      const found = where(chart, event);
      if (!start || !found || found.panel !== start.panel) return null;
      const [dx, dy] = [Math.abs(found.at.x - start.at.x), Math.abs(found.at.y - start.at.y)];
      return { found, wide: dx > SHORTEST_DRAG, high: dy > SHORTEST_DRAG && (chart.loop || dx <= SHORTEST_DRAG || dy > 2 * SHORTEST_DRAG) };
    };
    chart.svg.addEventListener('pointermove', event => {
      const found = where(chart, event);
      if (!found) return linked(chart).forEach(clear);
      if (chart.loop) nearest(chart, found);
      else linked(chart).forEach(other => show(other, other.x.share(chart.x.value(found.x))));
      const drag = ends(event);
      if (frame && drag) {
        const { panel, at } = start;
        const [x0, x1] = drag.wide ? [at.x, found.at.x].sort((a, b) => a - b) : [panel.left, panel.right];
        const [y0, y1] = drag.high ? [at.y, found.at.y].sort((a, b) => a - b) : [panel.top, panel.bottom];
        frame.setAttribute('d', `M${x0} ${y0}H${x1}V${y1}H${x0}Z`);
      }
    });
    chart.svg.addEventListener('pointerleave', () => linked(chart).forEach(clear));
    chart.svg.addEventListener('pointerdown', event => {
      if (event.pointerType === 'touch' || event.button !== 0) return;
      start = where(chart, event);
      if (!start) return;
      event.preventDefault();
      chart.svg.setPointerCapture(event.pointerId);
      frame = make(chart.svg, 'path', { class: 'choice', d: '' });
    });
    chart.svg.addEventListener('pointerup', event => {
      const drag = ends(event);
      frame?.remove();
      frame = null;
      if (drag && (drag.wide || drag.high)) {
        if (drag.high) start.panel.y.shown = [start.y, drag.found.y].sort((a, b) => a - b);
        zoom(chart, drag.wide ? [start.x, drag.found.x].sort((a, b) => a - b).map(chart.x.value) : chart.x.shown.map(chart.x.value));
      }
      start = null;
    });
    chart.svg.addEventListener('dblclick', () => all(chart));
  });

  // A button that copies a text.
  const copyButton = text => {
    const copy = document.createElement('button');
    copy.className = 'copy tools';
    copy.textContent = 'copy';
    copy.addEventListener('click', () => {
      const area = document.createElement('textarea');
      area.value = text();
      document.body.append(area);
      area.select();
      document.execCommand('copy');
      area.remove();
      copy.textContent = 'copied';
    });
    return copy;
  };
  document.querySelectorAll('pre.command').forEach(line => line.after(copyButton(() => line.textContent)));

  // Tables: sorted by the column that is clicked, copied as text with tabs.
  const number = text => { const value = parseFloat(text.replace('\u2212', '-')); return Number.isNaN(value) ? null : value; };
  document.querySelectorAll('.scroll > table').forEach(table => {
    const [head, ...rows] = [...table.rows];
    if (rows.length < 2) return;
    [...head.cells].forEach((cell, column) => {
      if (!cell.textContent) return;
      const button = document.createElement('button');
      button.className = 'sort';
      button.textContent = cell.textContent;
      cell.replaceChildren(button);
      button.addEventListener('click', () => {
        const down = cell.getAttribute('aria-sort') === 'ascending';
        [...head.cells].forEach(other => other.removeAttribute('aria-sort'));
        cell.setAttribute('aria-sort', down ? 'descending' : 'ascending');
        const value = row => { const text = row.cells[column]?.textContent.trim() || ''; return [number(text), text]; };
        const order = (a, b) => {
          const [[x, s], [y, t]] = [value(a), value(b)];
          return x !== null && y !== null ? x - y : x !== null ? -1 : y !== null ? 1 : s.localeCompare(t);
        };
        rows.sort((a, b) => down ? order(b, a) : order(a, b)).forEach(row => row.parentNode.append(row));
      });
    });
    const text = () => [...table.rows].map(row => [...row.cells].map(cell => cell.textContent.trim()).join('\t')).join('\n');
    table.parentNode.after(copyButton(text));
  });
})();
