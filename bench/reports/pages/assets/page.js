"use strict";
(async () => {
  const figures = [...document.querySelectorAll("figure.plot")];
  const coarse = matchMedia("(pointer: coarse)").matches;
  const PRINT_WIDTH = 660; // px, inside the margins of a sheet

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
  if (!figures.length) return;

  const plotly = await unpacked(document.getElementById("plotly").textContent);
  if (!plotly) return; // the stills stay
  const script = document.createElement("script");
  script.textContent = plotly;
  document.head.append(script);
  const waiting = new Set(figures); // what is folded has no width: it is drawn when it opens
  const open = () => [...waiting].filter((figure) => !figure.closest("details:not([open])"));
  const drawOpen = () => { for (const figure of open()) { waiting.delete(figure); draw(figure); } };
  for (const figure of open()) {
    waiting.delete(figure);
    draw(figure);
    await new Promise((next) => setTimeout(next)); // the page answers in between
  }
  for (const each of document.querySelectorAll("details")) each.addEventListener("toggle", drawOpen);
  addEventListener("beforeprint", () => { drawOpen(); resize(PRINT_WIDTH); });
  addEventListener("afterprint", () => resize(null));
  document.documentElement.dataset.drawn = figures.length;

  /** The library as text, or null where the browser cannot unpack it. */
  async function unpacked(base64) {
    if (!("DecompressionStream" in window)) return null;
    const bytes = Uint8Array.from(atob(base64), (sign) => sign.charCodeAt(0));
    return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).text();
  }

  function draw(figure) {
    const spec = JSON.parse(figure.querySelector("script").textContent);
    const canvas = figure.querySelector(".canvas");
    for (const part of [canvas, figure.querySelector(".controls")]) part.hidden = false;
    figure.querySelector(".still").hidden = true;
    if (figure.dataset.kind === "orbits") return drawOrbits(figure, canvas, spec);
    const layout = { ...spec.layout, autosize: true };
    if (coarse) layout.dragmode = false; // a finger scrolls the page; the buttons zoom
    const narrow = canvas.clientWidth < 520;
    if (narrow && layout.narrow) Object.assign(layout, layout.narrow);
    if (layout.height) canvas.style.height = `${layout.height}px`;
    Object.assign(layout, marks(figure, spec.layout));
    Plotly.newPlot(canvas, seen(figure, spec.data), layout, { displayModeBar: false, responsive: true, displaylogo: false });
    for (const select of figure.querySelectorAll("select"))
      select.addEventListener("change", () => {
        const traces = seen(figure, spec.data);
        Plotly.restyle(canvas, { visible: traces.map((trace) => trace.visible ?? true) });
        Plotly.relayout(canvas, marks(figure, spec.layout));
        reset(canvas);
      });
    const doing = { in: () => zoom(canvas, 0.7), out: () => zoom(canvas, 1 / 0.7), reset: () => reset(canvas),
      save: () => Plotly.downloadImage(onWhite(canvas), { format: "png", scale: 2, filename: figure.id,
        width: canvas.clientWidth, height: canvas.clientHeight }) };
    for (const button of figure.querySelectorAll("button[data-do]")) button.addEventListener("click", doing[button.dataset.do]);
  }

  /** A plot as it is zoomed, on a ground of its own: what is saved is seen elsewhere. */
  function onWhite({ data, layout }) { return { data, layout: { ...layout, paper_bgcolor: "#ffffff" } }; }

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

  function zoom(canvas, factor) {
    const ranges = {};
    for (const name of axes(canvas)) {
      const [low, high] = canvas._fullLayout[name].range.map(Number);
      if (Number.isNaN(low + high)) continue;
      const middle = (low + high) / 2, half = factor * (high - low) / 2;
      ranges[name + ".range"] = [middle - half, middle + half];
    }
    Plotly.relayout(canvas, ranges);
  }

  function reset(canvas) {
    const given = JSON.parse(canvas.closest("figure").querySelector("script").textContent).layout ?? {};
    const ranges = {};
    for (const name of axes(canvas)) {
      if (given[name]?.range) ranges[name + ".range"] = given[name].range;
      else ranges[name + ".autorange"] = given[name]?.autorange ?? true;
    }
    Plotly.relayout(canvas, ranges);
  }

  /** A text in which plotly finds no markup. */
  function inert(text) { return text.replaceAll("&", "&amp;").replaceAll("<", "&lt;"); }

  function drawOrbits(figure, canvas, spec) {
    const slider = figure.querySelector("input"), output = figure.querySelector("output");
    const colours = { measured: "#d1581f", model: "#2b7ab8" }, names = Object.keys(spec.planes);
    const turn = Array.from({ length: 73 }, (_, step) => (2 * Math.PI * step) / 72);
    const layout = { autosize: true, margin: { l: 56, r: 10, t: 56, b: 46 }, showlegend: true, dragmode: false,
      font: { size: 12, family: "system-ui, sans-serif" }, paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
      legend: { orientation: "h", x: 0, y: 1, yref: "container", yanchor: "top" },
      grid: { rows: 1, columns: names.length, pattern: "independent", xgap: 0.15 }, annotations: [] };
    names.forEach((name, index) => {
      const end = index ? index + 1 : "";
      layout["xaxis" + end] = { title: { text: "x (µm)" }, constrain: "domain" };
      layout["yaxis" + end] = { title: index ? undefined : { text: "y (µm)" }, scaleanchor: "x" + end, constrain: "domain" };
      layout.annotations.push({ text: inert(name), showarrow: false, xref: `x${end} domain`, yref: `y${end} domain`, x: 0.5, y: 1.09 });
    });
    function traces(at) {
      return names.flatMap((name, index) => Object.entries(spec.planes[name]).flatMap(([kind, phasors]) => {
        const [xr, xi, yr, yi] = phasors[at];
        const point = (real, imaginary) => turn.map((t) => real * Math.cos(t) - imaginary * Math.sin(t));
        const end = index ? index + 1 : "";
        const common = { xaxis: "x" + end, yaxis: "y" + end, legendgroup: kind, hoverinfo: "x+y" };
        return [{ ...common, x: point(xr, xi), y: point(yr, yi), mode: "lines", name: kind, showlegend: !index,
            line: { color: colours[kind] ?? "#7a7a7a", width: 2, dash: kind === "model" ? "solid" : "dot" } },
          { ...common, x: [xr], y: [yr], mode: "markers", showlegend: false, marker: { color: colours[kind], size: 8 } }];
      }));
    }
    /** Above 0 where the orbit turns as the shaft does: x y' − y x' is the same at every instant. */
    const whirl = ([xr, xi, yr, yi]) => (xi * yr - xr * yi >= 0 ? "forward" : "backward");
    const show = () => {
      const at = Number(slider.value);
      const said = names.map((name) => `${name}: ${whirl(Object.values(spec.planes[name])[0][at])} whirl`).join("; ");
      output.textContent = `${spec.speed[at].toFixed(0)} rpm; ${said}`;
      slider.setAttribute("aria-valuetext", output.textContent);
      Plotly.react(canvas, traces(at), layout, { displayModeBar: false, responsive: true });
    };
    slider.addEventListener("input", show);
    show();
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
