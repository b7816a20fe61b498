// The drawing that a student changes by hand. The browser sends the positions of what was dragged,
// and Python (widget.py) sends back what the student's function makes of them.

const SVG = "http://www.w3.org/2000/svg";
const WIDEST = 640; // pixels
const TALLEST = 560; // pixels
const MARGIN = { left: 52, right: 14, top: 10, bottom: 42 }; // pixels
const SLOW = 500; // milliseconds without an answer until the page says "computing"
const MOST_POINTS = 60;

// A drawing is light, like the course's figures, and a dark notebook inverts both in the same way.
const STYLE = `
.by-hand { max-width: ${WIDEST}px; }
.by-hand[hidden] { display: none; }
.by-hand-figure { background: #fff; color: #1b1f24; padding: 6px 0 2px;
  font: 13px "DejaVu Sans", Verdana, sans-serif; }
[data-jp-theme-light="false"] .by-hand-figure, .vscode-dark .by-hand-figure,
html[theme="dark"] .by-hand-figure { filter: invert(0.9) hue-rotate(180deg); }
.by-hand-title { font-weight: bold; min-height: 1.3em; padding: 0 8px; }
.by-hand-legend { display: flex; flex-wrap: wrap; gap: 2px 14px; min-height: 1.4em; padding: 2px 8px; }
.by-hand-legend span { display: inline-flex; align-items: center; gap: 5px; }
.by-hand svg { display: block; font: inherit; user-select: none; -webkit-user-select: none; }
.by-hand-handle { cursor: grab; touch-action: none; outline: none; }
.by-hand-handle:active { cursor: grabbing; }
.by-hand-handle .quiet { opacity: 0; }
.by-hand-handle:hover .quiet, .by-hand-handle.chosen .quiet { opacity: 1; }
.by-hand-handle:focus .ring { opacity: 1; stroke-width: 3.5; stroke: #0072b2; }
.by-hand-below { display: flex; flex-wrap: wrap; gap: 6px 10px; align-items: center; padding: 4px 8px; }
.by-hand-below button { font: inherit; padding: 3px 10px; border: 1px solid currentColor;
  border-radius: 3px; background: transparent; color: inherit; cursor: pointer; }
.by-hand-below button:disabled { opacity: 0.5; cursor: default; }
.by-hand-message { margin: 0; padding: 0 8px; min-height: 1.4em; overflow-wrap: anywhere; }
.by-hand-below, .by-hand-message { color: var(--jp-ui-font-color1, var(--vscode-foreground, inherit));
  font: 13px var(--jp-ui-font-family, sans-serif); }
`;

const SHAPES = {
  o: (r) => `M${-r} 0a${r} ${r} 0 1 0 ${2 * r} 0a${r} ${r} 0 1 0 ${-2 * r} 0z`,
  "^": (r) => `M0 ${-r}L${r} ${r}H${-r}z`,
  v: (r) => `M0 ${r}L${r} ${-r}H${-r}z`,
  s: (r) => `M${-r} ${-r}h${2 * r}v${2 * r}h${-2 * r}z`,
  D: (r) => `M0 ${-1.3 * r}L${1.3 * r} 0L0 ${1.3 * r}L${-1.3 * r} 0z`,
  P: (r) => `M${-r / 2.5} ${-r}h${r / 1.25}v${r * 0.6}h${r * 0.6}v${r / 1.25}h${-r * 0.6}v${r * 0.6}` +
    `h${-r / 1.25}v${-r * 0.6}h${-r * 0.6}v${-r / 1.25}h${r * 0.6}z`,
  x: (r) => `M${-r} ${-r}L${r} ${r}M${-r} ${r}L${r} ${-r}`,
};
const DASHES = ["none", "7 4", "2 3"];

const number = (value, digits) => value.toFixed(digits).replace("-", "−");
const clamp = (value, [low, high]) => Math.min(Math.max(value, low), high);

// Create an SVG element with attributes and children.
function make(tag, attributes = {}, ...children) {
  const element = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children);
  return element;
}

function html(tag, className, text = "") {
  const element = document.createElement(tag);
  if (className) element.className = className;
  element.textContent = text;
  return element;
}

function marker(kind, colour, radius) {
  const isCross = kind === "x";
  return make("path", {
    d: SHAPES[kind](isCross ? 0.8 * radius : radius),
    fill: isCross ? "none" : colour,
    stroke: isCross ? colour : "#fff",
    "stroke-width": isCross ? 2 : 0.8,
  });
}

// Return round numbers in an interval, at least 55 pixels apart.
function ticks([low, high], scale) {
  const coarse = 10 ** Math.ceil(Math.log10(55 / scale));
  const step = [coarse / 5, coarse / 2, coarse].find((one) => one * scale >= 55);
  const found = [];
  for (let n = Math.ceil(low / step); n * step <= high + 1e-9; n++) found.push(n * step);
  return { values: found, digits: Math.max(0, -Math.floor(Math.log10(step) + 1e-9)) };
}

function render({ model, el }) {
  const board = model.get("board");
  const { colours, limits, movable, canAdd } = board;
  let points, circle; // where the student put them
  let shapes = {}; // the answer of the student's function, empty after an exception
  let waiting = null; // the request that Python has not answered yet
  let isOutdated = false; // whether something moved after this request
  let timer = null;
  let chosen = -1; // the handle that was focused last
  let scale, width, height, pointSize;

  const root = html("div", "by-hand");
  // Otherwise, JupyterLab would move to the next cell when the student presses an arrow key.
  root.dataset.lmSuppressShortcuts = "true";
  root.hidden = true; // until Python answers; an exported page has no Python and keeps its figure
  const figure = html("div", "by-hand-figure");
  const title = html("div", "by-hand-title");
  const legend = html("div", "by-hand-legend");
  const svg = make("svg", { role: "group", "aria-label": "Drawing" });
  const axes = make("g");
  const picture = make("g");
  const handles = make("g");
  const message = html("p", "by-hand-message");
  message.setAttribute("role", "status");
  figure.append(title, legend, svg);
  const below = html("div", "by-hand-below");
  root.append(html("style", "", STYLE), figure, below, message);
  el.append(root);

  // ---- coordinates ------------------------------------------------------------------------------

  const toX = (x) => MARGIN.left + (x - limits[0][0]) * scale;
  const toY = (y) => MARGIN.top + (limits[1][1] - y) * scale;

  function metres(event) {
    const there = new DOMPoint(event.clientX, event.clientY).matrixTransform(
      svg.getScreenCTM().inverse());
    return [limits[0][0] + (there.x - MARGIN.left) / scale,
      limits[1][1] - (there.y - MARGIN.top) / scale];
  }

  function layOut() {
    const [across, up] = limits.map(([low, high]) => high - low);
    const available = Math.min(el.clientWidth || WIDEST, WIDEST);
    scale = Math.min((available - MARGIN.left - MARGIN.right) / across, TALLEST / up);
    width = across * scale;
    height = up * scale;
    pointSize = clamp(Math.sqrt(width) / Math.max(board.points.length, 1) ** 0.3, [3, 8]);
    const size = [width + MARGIN.left + MARGIN.right, height + MARGIN.top + MARGIN.bottom];
    svg.setAttribute("width", size[0]);
    svg.setAttribute("height", size[1]);
    svg.setAttribute("viewBox", `0 0 ${size[0]} ${size[1]}`);
    drawAxes();
  }

  // ---- drawing ----------------------------------------------------------------------------------

  function drawAxes() {
    const right = MARGIN.left + width, bottom = MARGIN.top + height;
    const clip = `clip-${Math.random().toString(36).slice(2)}`;
    const region = { x: MARGIN.left, y: MARGIN.top, width, height };
    axes.replaceChildren(make("clipPath", { id: clip }, make("rect", region)));
    picture.setAttribute("clip-path", `url(#${clip})`);
    const text = { fill: colours.ink, "font-size": 12 };
    const line = { stroke: colours.grid, "stroke-width": 0.8 };
    const horizontal = ticks(limits[0], scale), vertical = ticks(limits[1], scale);
    for (const x of horizontal.values) {
      const place = toX(x);
      axes.append(make("line", { x1: place, x2: place, y1: MARGIN.top, y2: bottom, ...line }),
        make("text", { x: place, y: bottom + 16, "text-anchor": "middle", ...text },
          number(x, horizontal.digits)));
    }
    for (const y of vertical.values) {
      const place = toY(y);
      axes.append(make("line", { x1: MARGIN.left, x2: right, y1: place, y2: place, ...line }),
        make("text", { x: MARGIN.left - 6, y: place + 4, "text-anchor": "end", ...text },
          number(y, vertical.digits)));
    }
    axes.append(
      make("path", { d: `M${MARGIN.left} ${MARGIN.top}V${bottom}H${right}`, fill: "none",
        stroke: colours.muted, "stroke-width": 0.8 }),
      make("text", { x: MARGIN.left + width / 2, y: bottom + 35, "text-anchor": "middle", ...text },
        "x (m)"),
      make("text", { transform: `translate(14 ${MARGIN.top + height / 2}) rotate(-90)`,
        "text-anchor": "middle", ...text }, "y (m)"));
  }

  function polygon(corners, attributes) {
    const path = corners.map(([x, y]) => `${toX(x)},${toY(y)}`).join(" ");
    return make("polygon", { points: path, ...attributes });
  }

  function drawPicture() {
    const entries = [];
    const key = (text, draw) => entries.push([text, draw]);
    const drawn = [];
    for (const { name, boxes } of shapes.rectangles ?? []) {
      const look = { fill: colours.grid, stroke: colours.pale };
      for (const [left, low, right, high] of boxes) {
        drawn.push(polygon([[left, low], [right, low], [right, high], [left, high]], look));
      }
      key(`${name}: ${boxes.length}`, () => make("rect", { x: 2, y: 3, width: 18, height: 10, ...look }));
    }
    if (shapes.band) {
      const look = { fill: colours.green, "fill-opacity": 0.18, stroke: colours.green };
      drawn.push(polygon(shapes.band.corners, look));
      key(shapes.band.name, () => make("rect", { x: 2, y: 3, width: 18, height: 10, ...look }));
    }
    for (const [i, j] of shapes.edges ?? []) {
      if (!points[i] || !points[j]) continue; // removed since the question
      drawn.push(make("line", { x1: toX(points[i][0]), y1: toY(points[i][1]), x2: toX(points[j][0]),
        y2: toY(points[j][1]), stroke: colours.muted, "stroke-width": 1.4 }));
    }
    (shapes.lines ?? []).forEach(({ name, ends: [start, end] }, n) => {
      const look = { stroke: colours.ink, "stroke-width": 2, "stroke-dasharray": DASHES[n] };
      drawn.push(make("line", { x1: toX(start[0]), y1: toY(start[1]), x2: toX(end[0]),
        y2: toY(end[1]), class: "by-hand-line", ...look }));
      key(name, () => make("line", { x1: 0, x2: 22, y1: 8, y2: 8, ...look }));
    });
    if (circle) {
      const [x, y, radius] = circle, r = radius * scale;
      const look = { fill: "none", stroke: colours.ink, "stroke-width": 1.4 };
      drawn.push(
        make("rect", { x: toX(x) - r, y: toY(y) - r, width: 2 * r, height: 2 * r, ...look,
          "stroke-dasharray": "2 3" }),
        make("circle", { cx: toX(x), cy: toY(y), r, ...look, fill: colours.orange,
          "fill-opacity": 0.22 }));
    }
    const groupOf = new Map();
    for (const group of shapes.groups ?? []) {
      for (const row of group.rows) groupOf.set(row, group);
      if (group.legend) {
        key(group.legend, () => make("g", { transform: "translate(11 8)" },
          marker(group.marker, group.colour, 5)));
      }
    }
    points.forEach(([x, y], row) => {
      const group = groupOf.get(row);
      const place = make("g", { transform: `translate(${toX(x)} ${toY(y)})`, class: "by-hand-point" },
        make("title", {}, describe(row)),
        marker(group?.marker ?? "o", group?.colour ?? colours.ink, pointSize));
      if (group?.number) {
        place.append(make("text", { x: 9, y: -8, "font-size": 12, fill: colours.ink,
          stroke: "#fff", "stroke-width": 3, "paint-order": "stroke" }, group.number));
      }
      drawn.push(place);
    });
    picture.replaceChildren(...drawn);
    title.textContent = shapes.title ?? "";
    legend.replaceChildren(...entries.map(([text, draw]) => {
      const entry = html("span");
      entry.append(make("svg", { width: 22, height: 16, "aria-hidden": "true" }, draw()), text);
      return entry;
    }));
    svg.setAttribute("aria-label", `Drawing. ${title.textContent}`);
  }

  function describe(row) {
    const [x, y] = points[row];
    const group = (shapes.groups ?? []).find((one) => one.rows.includes(row));
    const label = group ? `: ${group.text}` : "";
    return `point ${row} at (${number(x, 2)}, ${number(y, 2)})${label}`;
  }

  // ---- handles ----------------------------------------------------------------------------------

  // Everything that can be dragged: its name, its place, and how it moves to another place.
  function things() {
    if (circle) {
      const [x, y, radius] = circle;
      return [
        { name: () => `circle at (${number(x, 2)}, ${number(y, 2)})`, place: [x, y], isCross: true,
          move: ([toX, toY]) => { circle = [toX, toY, circle[2]]; } },
        { name: () => `radius ${number(radius, 2)} m`, place: [x + radius, y],
          move: ([toX]) => {
            const longest = board.largestRadius;
            circle = [circle[0], circle[1], clamp(round(toX - circle[0]), [0.1, longest])];
          } },
      ];
    }
    const rows = canAdd ? points.keys() : movable;
    return [...rows].map((row) => ({
      name: () => describe(row),
      place: points[row],
      isQuiet: canAdd || movable.length === points.length,
      move: (there) => { points[row] = there; },
    }));
  }

  const round = (value) => Math.round(100 * value) / 100;
  const inside = (there) => there.map((value, axis) => round(clamp(value, limits[axis])));

  function moveTo(index, there) {
    things()[index].move(inside(there));
    ask();
    paint();
  }

  // Elements stay while they are dragged, because a new element would lose the pointer.
  function drawHandles() {
    const list = things();
    while (handles.children.length > list.length) handles.lastChild.remove();
    while (handles.children.length < list.length) {
      handles.append(newHandle(handles.children.length, list[handles.children.length]));
    }
    list.forEach((thing, index) => {
      const handle = handles.children[index];
      const [x, y] = thing.place;
      // At the edge of the region, the radius must stay within reach.
      const [left, top] = [toX(clamp(x, limits[0])), toY(y)];
      handle.setAttribute("transform", `translate(${left} ${top})`);
      handle.classList.toggle("chosen", index === chosen);
      handle.querySelector(".ring").setAttribute("r", pointSize + 5);
      handle.setAttribute("aria-label", thing.name());
      handle.querySelector("title").textContent = thing.name();
    });
  }

  function newHandle(index, thing) {
    const ring = { fill: "none", stroke: colours.ink, "stroke-width": 1.8 };
    const handle = make("g", { class: "by-hand-handle", tabindex: 0, role: "application",
      "aria-roledescription": "draggable" }, make("title"),
      make("circle", { r: 18, fill: "transparent" }),
      make("circle", { ...ring, class: thing.isQuiet ? "ring quiet" : "ring" }));
    if (thing.isCross) {
      handle.append(make("path", { d: "M-6 0H6M0 -6V6", stroke: colours.ink, "stroke-width": 2 }));
    }
    let offset = null; // from the pointer to the thing, while it is dragged
    handle.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      const [x, y] = metres(event), [atX, atY] = things()[index].place;
      offset = [atX - x, atY - y];
      handle.setPointerCapture(event.pointerId);
      handle.focus({ preventScroll: true });
    });
    handle.addEventListener("pointermove", (event) => {
      if (!offset) return;
      const [x, y] = metres(event);
      moveTo(index, [x + offset[0], y + offset[1]]);
    });
    for (const end of ["pointerup", "pointercancel"]) {
      handle.addEventListener(end, () => { offset = null; });
    }
    // A notebook would take the focus away, and a click on a point must not add another point.
    handle.addEventListener("mousedown", (event) => event.stopPropagation());
    handle.addEventListener("click", (event) => event.stopPropagation());
    handle.addEventListener("focus", () => {
      chosen = index;
      paint();
    });
    handle.addEventListener("keydown", (event) => {
      const step = event.shiftKey ? 1 : 0.1; // metres
      const by = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, step],
        ArrowDown: [0, -step] }[event.key];
      if (by) {
        const [x, y] = things()[index].place;
        moveTo(index, [x + by[0], y + by[1]]);
      } else if (canAdd && (event.key === "Delete" || event.key === "Backspace")) {
        remove();
      } else {
        return;
      }
      event.preventDefault();
      event.stopPropagation();
    });
    return handle;
  }

  // ---- buttons ----------------------------------------------------------------------------------

  function button(text, action) {
    const element = html("button", "", text);
    element.type = "button";
    element.addEventListener("click", action);
    below.append(element);
    return element;
  }

  function add(there) {
    if (points.length >= MOST_POINTS) return;
    points.push(inside(there));
    ask();
    paint();
    handles.lastChild.focus({ preventScroll: true });
  }

  function remove() {
    points.splice(chosen, 1);
    chosen = Math.min(chosen, points.length - 1);
    shapes = {}; // its rows are those of other points
    ask();
    paint();
    handles.children[chosen]?.focus({ preventScroll: true });
  }

  function startAgain() {
    points = board.points.map((point) => [...point]);
    circle = board.circle && [...board.circle];
    shapes = {};
    chosen = -1;
    ask();
    paint();
  }

  let addButton, removeButton;
  if (canAdd) {
    addButton = button("Add a point", () => add(limits.map(([low, high]) => (low + high) / 2)));
    removeButton = button("Remove the point", remove);
    svg.addEventListener("click", (event) => {
      const there = metres(event);
      if (there.every((value, axis) => value === clamp(value, limits[axis]))) add(there);
    });
    svg.style.cursor = "crosshair";
  }
  button("Start again", startAgain);
  below.append(html("span", "", (canAdd ? "Click to add a point. Drag it, or"
    : board.circle ? "Drag the cross or the edge, or" : "Drag, or")
    + " press Tab and use the arrow keys." + (canAdd ? " Delete removes it." : "")));

  function updateButtons() {
    if (!canAdd) return;
    addButton.disabled = points.length >= MOST_POINTS;
    removeButton.disabled = chosen < 0;
  }

  // ---- Python -----------------------------------------------------------------------------------

  // Send the newest positions, but not before Python has answered the previous ones.
  function ask() {
    isOutdated = waiting !== null;
    if (isOutdated) return;
    waiting = Math.random();
    timer = setTimeout(() => { message.textContent = "computing …"; }, SLOW);
    model.send({ request: waiting, points, circle });
  }

  function receive() {
    const answer = model.get("answer");
    if (answer.request === undefined) return;
    if (answer.request === waiting) {
      clearTimeout(timer);
      waiting = null;
      reveal();
    } else if (waiting !== null) {
      return; // the answer to another view of this drawing
    } else {
      ({ points, circle } = structuredClone(answer));
    }
    shapes = answer.shapes;
    message.textContent = answer.problem;
    paint();
    if (isOutdated) ask();
  }

  // Show the drawing instead of the figure above it.
  function reveal() {
    root.hidden = false;
    for (const still of document.getElementsByClassName(board.still)) still.hidden = true;
    if (!scale) layOut();
  }

  function paint() {
    if (!scale) return;
    drawPicture();
    drawHandles();
    updateButtons();
  }

  svg.append(axes, picture, handles);
  const answer = model.get("answer");
  const start = structuredClone(answer.request === undefined ? board : answer);
  ({ points, circle } = start);
  model.on("change:answer", receive);
  const observer = new ResizeObserver(() => {
    if (root.hidden || !el.clientWidth) return;
    layOut();
    paint();
  });
  observer.observe(el);
  ask();
  return () => {
    model.off("change:answer", receive);
    observer.disconnect();
    clearTimeout(timer);
  };
}

export default { render };
