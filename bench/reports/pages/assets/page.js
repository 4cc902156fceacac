"use strict";
(async () => {
  const figures = [...document.querySelectorAll("figure.plot")];
  const coarse = matchMedia("(pointer: coarse)").matches;
  const TITLE_LINE = 20; // px, of a title that a saved picture has
  const ORBIT_ROOM = 1.15, TICK = 70; // times an orbit's reach: where its axes end; px for each of their numbers
  const PRINT_WIDTH = 660; // px, inside the margins of a sheet
  const NARROW = 520, ORBIT_HEIGHT = 340; // px: a plot that is less wide has its panels one over another; of one orbit there

  for (const button of document.querySelectorAll("button[data-do=copy]")) {
    button.hidden = false;
    button.addEventListener("click", async () => {
      const code = button.parentElement.querySelector("code");
      try { await navigator.clipboard.writeText(code.textContent); button.textContent = "Copied"; }
      catch { getSelection().selectAllChildren(code); }
    });
  }
  for (const table of document.querySelectorAll("table")) makeSortable(table);
  for (const box of document.querySelectorAll(".scroll")) tellWidth(box);
  addEventListener("beforeprint", () => { for (const each of document.querySelectorAll("details")) each.open = true; });
  for (const input of document.querySelectorAll("[data-filter]")) makeFilter(input);
  if (!figures.length) return;

  const plotly = await unpacked(document.getElementById("plotly").textContent);
  if (!plotly) return; // the stills stay
  const script = document.createElement("script");
  script.textContent = plotly;
  document.head.append(script);
  const onDark = JSON.parse(document.getElementById("dark").textContent); // colours are written as on a white ground
  const onWhite = Object.fromEntries(Object.entries(onDark).map(([light, dark]) => [dark, light]));
  const darkness = matchMedia("(prefers-color-scheme: dark)");
  let isDark = darkness.matches;
  const texts = new Map(), specs = new Map(); // all before the first is drawn: printing draws what is folded at once
  for (const figure of figures) texts.set(figure, await dataOf(figure));
  for (const figure of figures) specs.set(figure, parsed(texts.get(figure)));
  const waiting = new Set(figures); // what is folded has no width: it is drawn when it opens
  const open = () => [...waiting].filter((figure) => !figure.closest("details:not([open])"));
  darkness.addEventListener("change", () => paint(darkness.matches)); // also while figures are drawn
  const drawOpen = () => { for (const figure of open()) { waiting.delete(figure); draw(figure); } };
  for (const figure of open()) {
    waiting.delete(figure);
    draw(figure);
    await new Promise((next) => setTimeout(next)); // the page answers in between
  }
  for (const each of document.querySelectorAll("details")) each.addEventListener("toggle", drawOpen);
  addEventListener("beforeprint", () => { drawOpen(); paint(false); resize(PRINT_WIDTH); });
  addEventListener("afterprint", () => { paint(darkness.matches); resize(null); });
  document.documentElement.dataset.drawn = figures.length;

  /** The data of a plot, which are packed where they are many. */
  function dataOf(figure) {
    const script = figure.querySelector("script");
    return script.dataset.packed === undefined ? script.textContent : unpacked(script.textContent);
  }

  /** A packed text, or null where the browser cannot unpack it. */
  async function unpacked(base64) {
    if (!("DecompressionStream" in window)) return null;
    const bytes = Uint8Array.from(atob(base64), (sign) => sign.charCodeAt(0));
    return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).text();
  }

  /** What a plot is drawn from, in the colours of the ground, each trace with its own numbers. */
  function parsed(text) {
    const spec = JSON.parse(isDark ? recoloured(text, onDark) : text);
    for (const trace of spec.data ?? [])
      for (const side of ["x", "y"]) if (trace[side]?.shared !== undefined) trace[side] = spec.shared[trace[side].shared];
    return spec;
  }

  /** A text with other colours, opaque and faded ones. */
  function recoloured(text, colours) {
    return text.replace(/#[0-9a-f]{6}\b|rgba\((\d+),(\d+),(\d+),/g, (found, ...parts) => {
      if (found[0] === "#") return colours[found] ?? found;
      const other = colours["#" + parts.slice(0, 3).map((part) => Number(part).toString(16).padStart(2, "0")).join("")];
      return other ? `rgba(${[1, 3, 5].map((at) => parseInt(other.slice(at, at + 2), 16)).join(",")},` : found;
    });
  }

  /** All figures in the colours of a ground, as they are zoomed and chosen. */
  function paint(toDark) {
    if (toDark === isDark) return;
    isDark = toDark;
    for (const figure of figures) {
      specs.set(figure, parsed(texts.get(figure)));
      const canvas = figure.querySelector(".canvas");
      if (!waiting.has(figure)) Plotly.react(canvas, ...JSON.parse(recoloured(JSON.stringify([canvas.data, canvas.layout]), isDark ? onDark : onWhite)));
    }
  }

  function draw(figure) {
    const spec = specs.get(figure);
    const canvas = figure.querySelector(".canvas");
    for (const part of [canvas, figure.querySelector(".controls")]) part.hidden = false;
    figure.querySelector(".still").hidden = true;
    if (figure.dataset.kind === "orbits") return drawOrbits(figure, canvas, spec);
    const layout = { ...structuredClone(spec.layout ?? {}), autosize: true }; // plotly changes it, a reset needs it as given
    if (coarse) layout.dragmode = false; // a finger scrolls the page, two zoom it
    const narrow = canvas.clientWidth < NARROW;
    if (narrow && layout.narrow) Object.assign(layout, layout.narrow);
    if (layout.height) canvas.style.height = `${layout.height}px`;
    Object.assign(layout, marks(figure, spec.layout));
    Plotly.newPlot(canvas, seen(figure, spec.data), layout, { displayModeBar: false, responsive: true, displaylogo: false });
    for (const select of figure.querySelectorAll("select"))
      select.addEventListener("change", () => {
        const traces = seen(figure, spec.data);
        Plotly.restyle(canvas, { visible: traces.map((trace) => trace.visible ?? true) });
        Plotly.relayout(canvas, marks(figure, specs.get(figure).layout));
        reset(canvas).then(() => { back.hidden = true; });
      });
    const back = figure.querySelector("button[data-do=reset]"); // there once something is to be reset
    canvas.on("plotly_relayout", (changed) => { back.hidden &&= !Object.keys(changed).some((name) => /axis\d*\.range/.test(name)); });
    back.addEventListener("click", () => reset(canvas).then(() => { back.hidden = true; }));
    makeSavable(figure, canvas);
  }

  /** Links below a figure that save it as it is seen: as a picture, or its numbers. */
  function makeSavable(figure, canvas) {
    const links = figure.querySelector(".save"), filename = figure.dataset.name;
    links.hidden = false;
    for (const button of links.querySelectorAll("button")) {
      const format = button.dataset.do;
      button.addEventListener("click", () => {
        if (format === "csv") return saveText(`${filename}.csv`, numbers(canvas));
        const lines = wrapped((figure.querySelector("h3") ?? document.querySelector("h1")).textContent, canvas.clientWidth / 7.5);
        Plotly.downloadImage(saved(canvas, lines), { format, scale: format === "png" ? 2 : 1, filename,
          width: canvas.clientWidth, height: canvas.clientHeight + TITLE_LINE * lines.length });
      });
    }
  }

  function saveText(filename, text) {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([text], { type: "text/csv" }));
    link.download = filename;
    link.click();
    URL.revokeObjectURL(link.href);
  }

  /** A plot as it is zoomed, below its title and on a ground of its own: what is saved is seen elsewhere. */
  function saved(canvas, lines) {
    const whole = JSON.stringify([canvas.data, canvas.layout]), [data, layout] = JSON.parse(isDark ? recoloured(whole, onWhite) : whole);
    const title = { text: lines.map(inert).join("<br>"), font: { size: 14 }, x: 0, xref: "container", xanchor: "left", y: 1, yref: "container", yanchor: "top", pad: { l: 8, t: 8 } };
    const margin = { ...layout.margin, t: (layout.margin?.t ?? 0) + TITLE_LINE * lines.length };
    return { data, layout: { ...layout, title, margin, height: undefined, width: undefined, paper_bgcolor: "#ffffff" } };
  }

  function wrapped(text, length) {
    const lines = [""];
    for (const word of text.split(" ")) {
      if (`${lines.at(-1)} ${word}`.length > length && lines.at(-1)) lines.push(word);
      else lines[lines.length - 1] = `${lines.at(-1)} ${word}`.trim();
    }
    return lines;
  }

  /** The numbers of a plot as it is chosen, as CSV: a row for each point, box, bar or cell, ends of its interval where it has one. */
  function numbers(canvas) {
    const plain = (text) => (text ?? "").replaceAll("<br>", " ").replace(/<[^>]*>/g, "");
    const quoted = (value) => (/[",\n]/.test(value) ? `"${value.replaceAll('"', '""')}"` : value);
    const rows = [["x axis", "y axis", "series", "x", "y", "x low", "x high", "y low", "y high", "value"]];
    for (const trace of canvas.data) {
      if (trace.visible === false) continue;
      const ids = [trace.xaxis ?? "x", trace.yaxis ?? "y"];
      const [x, y] = ids.map((id) => canvas.layout[axisOf(id)] ?? {});
      const names = ids.map((id) => plain(titleOf(canvas, id)));
      const said = (axis, value) => { const at = axis.tickvals?.indexOf(value) ?? -1; return at >= 0 ? plain(axis.ticktext[at]) : value; };
      const row = (at, value, ends = {}, number = "") =>
        rows.push([...names, plain(trace.name), said(x, at), said(y, value), ends.xl, ends.xh, ends.yl, ends.yh, number]);
      if (trace.type === "box") {
        const [own, other, ends] = trace.orientation === "h" ? ["x", "y0", ["xl", "xh"]] : ["y", "x0", ["yl", "yh"]];
        for (const [low, middle, high] of [[trace.q1[0], trace.median[0], trace.q3[0]]])
          row(own === "x" ? middle : trace[other], own === "y" ? middle : trace[other], { [ends[0]]: low, [ends[1]]: high });
      } else if (trace.type === "heatmap")
        trace.z.forEach((line, down) => line.forEach((z, right) => row(trace.x?.[right] ?? right, trace.y?.[down] ?? down, {}, plain(trace.text?.[down]?.[right] || String(z)))));
      else if (trace.x && trace.y)
        for (let index = 0; index < trace.x.length; index++) {
          if (trace.x[index] == null || trace.y[index] == null) continue;
          const base = trace.base?.[index] ?? 0, isFlat = trace.orientation === "h";
          const at = { x: trace.x[index] + (isFlat ? base : 0), y: trace.y[index] + (trace.type === "bar" && !isFlat ? base : 0) }, ends = {};
          for (const side of ["x", "y"]) {
            const error = trace["error_" + side];
            if (error) Object.assign(ends, { [side + "l"]: at[side] - error.arrayminus[index], [side + "h"]: at[side] + error.array[index] });
          }
          row(at.x, at.y, ends);
        }
    }
    return rows.map((row) => row.map((value) => quoted(String(value ?? ""))).join(",")).join("\n") + "\n";
  }

  function axisOf(id) { return `${id[0]}axis${id.slice(1)}`; }

  /** The words of an axis, which may stand at another panel that shares it. */
  function titleOf(canvas, id) {
    const first = canvas.layout[axisOf(id)]?.matches ?? id;
    const shared = Object.entries(canvas.layout).filter(([name, axis]) => name === axisOf(first) || (/^[xy]axis/.test(name) && axis.matches === first));
    return canvas.layout[axisOf(id)]?.title?.text || shared.map(([, axis]) => axis.title?.text).find(Boolean) || "";
  }

  /** Whether the selects leave in what has these tags. */
  function isSeen(figure, tags = {}) {
    const chosen = [...figure.querySelectorAll("select")].filter((select) => select.value);
    return chosen.every(({ dataset, value }) => !(dataset.key in tags) || tags[dataset.key] === value);
  }

  /** Traces with those hidden that the selects leave out. */
  function seen(figure, traces) {
    return traces.map((trace) => ({ ...trace, visible: isSeen(figure, trace.meta) ? trace.visible ?? true : false }));
  }

  /** Lines and words of a layout that the selects leave in. */
  function marks(figure, { shapes = [], annotations = [] }) {
    return { shapes: shapes.filter(({ meta }) => isSeen(figure, meta)), annotations: annotations.filter(({ meta }) => isSeen(figure, meta)) };
  }

  function axes(canvas) { return Object.keys(canvas._fullLayout).filter((name) => /^[xy]axis\d*$/.test(name)); }

  function reset(canvas) {
    const given = specs.get(canvas.closest("figure")).layout ?? {};
    const ranges = {};
    for (const name of axes(canvas)) {
      if (given[name]?.range) ranges[name + ".range"] = given[name].range;
      else ranges[name + ".autorange"] = given[name]?.autorange ?? true;
    }
    return Plotly.relayout(canvas, ranges);
  }

  /** A text in which plotly finds no markup. */
  function inert(text) { return text.replaceAll("&", "&amp;").replaceAll("<", "&lt;"); }

  function drawOrbits(figure, canvas, spec) {
    const slider = figure.querySelector("input"), output = figure.querySelector("output");
    const names = Object.keys(spec.planes), isNarrow = canvas.clientWidth < NARROW;
    const [rows, columns] = isNarrow ? [names.length, 1] : [1, names.length];
    if (isNarrow) canvas.style.height = `${ORBIT_HEIGHT * rows}px`;
    const turn = Array.from({ length: 73 }, (_, step) => (2 * Math.PI * step) / 72);
    const layout = { autosize: true, margin: { l: 56, r: 10, t: 56, b: 46 }, showlegend: true, dragmode: false,
      font: { size: 12, family: "system-ui, sans-serif" }, paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
      legend: { orientation: "h", x: 0, y: 1, yref: "container", yanchor: "top" },
      grid: { rows, columns, pattern: "independent", xgap: 0.15, ygap: 0.25 }, annotations: [] };
    const nticks = Math.max(4, Math.min(5, Math.floor(canvas.clientWidth / columns / TICK)));
    names.forEach((name, index) => {
      const end = index ? index + 1 : "";
      layout["xaxis" + end] = { title: { text: `x (${spec.unit})` }, constrain: "domain", tickangle: 0, nticks };
      layout["yaxis" + end] = { title: index && !isNarrow ? undefined : { text: `y (${spec.unit})` }, scaleanchor: "x" + end, constrain: "domain", nticks };
      layout.annotations.push({ text: inert(name), showarrow: false, xref: `x${end} domain`, yref: `y${end} domain`, x: 0.5, y: 1.09 });
    });
    function traces(at) {
      const { colours } = specs.get(figure);
      return names.flatMap((name, index) => Object.entries(spec.planes[name]).flatMap(([kind, phasors]) => {
        const [xr, xi, yr, yi] = phasors[at];
        const point = (real, imaginary) => turn.map((t) => real * Math.cos(t) - imaginary * Math.sin(t));
        const end = index ? index + 1 : "";
        const common = { xaxis: "x" + end, yaxis: "y" + end, legendgroup: kind, hoverinfo: "x+y" };
        return [{ ...common, x: point(xr, xi), y: point(yr, yi), mode: "lines", name: kind, showlegend: !index,
            line: { color: colours[kind], width: 2, dash: kind === "model" ? "solid" : "dot" } },
          { ...common, x: [xr], y: [yr], mode: "markers", showlegend: false, marker: { color: colours[kind], size: 8 } }];
      }));
    }
    /** Largest displacement in x or y. */
    const farthest = ([xr, xi, yr, yi]) => Math.max(Math.hypot(xr, xi), Math.hypot(yr, yi)) || 1;
    /** Above 0 where the orbit turns as the shaft does: x y' − y x' is the same at every instant. */
    const whirl = ([xr, xi, yr, yi]) => (xi * yr - xr * yi >= 0 ? "forward" : "backward");
    const show = () => {
      const at = Number(slider.value);
      const said = names.map((name) => `${name}: ${whirl(Object.values(spec.planes[name])[0][at])} whirl`).join("; ");
      output.textContent = `${spec.speed[at].toFixed(spec.decimals)} ${spec.speedUnit}; ${said}`;
      slider.setAttribute("aria-valuetext", output.textContent);
      for (const [index, name] of names.entries()) {
        const end = index ? index + 1 : "", reach = ORBIT_ROOM * Math.max(...Object.values(spec.planes[name]).map((kind) => farthest(kind[at])));
        for (const side of ["xaxis", "yaxis"]) layout[side + end] = { ...layout[side + end], range: [-reach, reach] };
      }
      Plotly.react(canvas, traces(at), { ...layout }, { displayModeBar: false, responsive: true });
    };
    slider.addEventListener("input", show);
    show();
    makeSavable(figure, canvas);
  }

  function resize(width) {
    for (const canvas of document.querySelectorAll(".canvas:not([hidden])")) {
      const half = canvas.closest(".grid") ? 0.48 : 1;
      Plotly.relayout(canvas, width ? { width: half * width, autosize: false } : { width: undefined, autosize: true });
    }
  }

  /** Above a box that is wider than the page, that it goes on to the right. */
  function tellWidth(box) {
    const said = document.createElement("p");
    said.className = "more";
    said.textContent = "Wider than the page: scroll sideways →";
    said.hidden = true;
    box.before(said);
    const look = () => { said.hidden = box.scrollWidth <= box.clientWidth + 1; };
    new ResizeObserver(look).observe(box);
    for (const image of box.querySelectorAll("img")) image.addEventListener("load", look);
  }

  /** A field that leaves the rows of the table which have all its words. */
  function makeFilter(input) {
    input.closest(".filter").hidden = false;
    input.addEventListener("input", () => {
      const words = input.value.toLowerCase().split(/\s+/);
      for (const row of document.querySelectorAll("tbody tr")) row.hidden = !words.every((word) => row.textContent.toLowerCase().includes(word));
    });
  }

  function makeSortable(table) {
    const body = table.tBodies[0];
    if (!body || body.rows.length < 3) return;
    [...table.tHead.rows[0].cells].forEach((cell, column) => {
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = cell.textContent;
      button.title = "sort";
      cell.replaceChildren(button);
      button.addEventListener("click", () => {
        const down = cell.getAttribute("aria-sort") === "ascending";
        for (const other of cell.parentElement.cells) other.removeAttribute("aria-sort");
        cell.setAttribute("aria-sort", down ? "descending" : "ascending");
        const value = (row) => row.cells[column].textContent.trim();
        const number = (text) => parseFloat(text.replace("−", "-").replace(/^[\[<>≤≥~± ]+/, ""));
        const rows = [...body.rows].sort((one, other) => {
          const [a, b] = [number(value(one)), number(value(other))];
          return Number.isNaN(a) || Number.isNaN(b) ? value(one).localeCompare(value(other)) : a - b;
        });
        body.append(...(down ? rows.reverse() : rows));
      });
    });
  }
})();
