// The playground on the front page: the course's scan in three dimensions. A worker finds the ground,
// clusters and boxes, so that sliders and the view never wait. Without WebGL, the film is shown.
(() => {
  const root = document.querySelector("figure.playground");
  if (!root) return;
  const LABELS = { ground: -3, far: -2, small: -1 }; // of points that are not in a cluster

  // ---- in the worker -------------------------------------------------------------------------------
  // All lengths are in steps of the scan, so points and squared gaps are whole numbers.
  const work = () => {
    const ROUNDS = 200, EVERY = 4, STEEPEST = 0.2; // planes, of which every fourth point is counted; slope
    let at, step, count;

    // The ground is a height z = a x + b y + c at each place. Steeper planes are walls.
    const findGround = (reach) => {
      let random = 1, best = [0, 0, 0], most = -1;
      const pick = () => 3 * ((random = (random * 48271) % 2147483647) % count);
      for (let round = 0; round < ROUNDS; round++) {
        const p = pick(), q = pick(), r = pick();
        const ux = at[q] - at[p], uy = at[q + 1] - at[p + 1], uz = at[q + 2] - at[p + 2];
        const vx = at[r] - at[p], vy = at[r + 1] - at[p + 1], vz = at[r + 2] - at[p + 2];
        const area = ux * vy - uy * vx, a = (uz * vy - uy * vz) / area, b = (ux * vz - uz * vx) / area;
        if (!(Math.abs(a) < STEEPEST && Math.abs(b) < STEEPEST)) continue; // also if the area is 0
        const c = at[p + 2] - a * at[p] - b * at[p + 1];
        let votes = 0;
        for (let i = 0; i < at.length; i += 3 * EVERY) {
          const above = at[i + 2] - (a * at[i] + b * at[i + 1] + c);
          if (above <= reach && above >= -reach) votes++;
        }
        if (votes > most) { most = votes; best = [a, b, c]; }
      }
      return best;
    };

    // A cell is half as wide as the largest gap, so all points of a cell belong together, and only cells
    // at most two apart can touch. The cells of a team form a ring. To join two teams, rename the smaller.
    const group = (label, gap) => {
      const side = gap / 2, cells = new Map(), places = [], first = [], next = new Int32Array(count);
      const nameOf = (x, y, z) => (x * 4096 + y) * 4096 + z;
      for (let i = 0; i < count; i++) {
        if (label[i] < 0) continue;
        const x = Math.floor(at[3 * i] / side) + 2048, y = Math.floor(at[3 * i + 1] / side) + 2048;
        const z = Math.floor(at[3 * i + 2] / side) + 2048, name = nameOf(x, y, z);
        let cell = cells.get(name);
        if (cell === undefined) {
          cells.set(name, (cell = first.length));
          places.push([x, y, z]);
          first.push(-1);
        }
        label[i] = cell;
        next[i] = first[cell];
        first[cell] = i;
      }
      const team = first.map((_, cell) => cell), ring = team.slice(), size = team.map(() => 1);
      const touch = (one, other) => {
        for (let i = first[one]; i >= 0; i = next[i]) {
          for (let j = first[other]; j >= 0; j = next[j]) {
            const x = at[3 * i] - at[3 * j], y = at[3 * i + 1] - at[3 * j + 1], z = at[3 * i + 2] - at[3 * j + 2];
            if (x * x + y * y + z * z < gap * gap) return true;
          }
        }
        return false;
      };
      const join = (one, other) => {
        if (size[team[one]] < size[team[other]]) [one, other] = [other, one];
        const name = team[one];
        size[name] += size[team[other]];
        for (let cell = other; team[cell] !== name; cell = ring[cell]) team[cell] = name;
        [ring[one], ring[other]] = [ring[other], ring[one]];
      };
      const around = [];
      for (let x = 0; x <= 2; x++) for (let y = -2; y <= 2; y++) for (let z = -2; z <= 2; z++) {
        if (nameOf(x, y, z) > 0) around.push(nameOf(x, y, z)); // the others have looked here
      }
      places.forEach((place, one) => {
        const name = nameOf(...place);
        for (const offset of around) {
          const other = cells.get(name + offset);
          if (other !== undefined && team[one] !== team[other] && touch(one, other)) join(one, other);
        }
      });
      for (let i = 0; i < count; i++) if (label[i] >= 0) label[i] = team[label[i]];
    };

    // Number the clusters that are large enough, and return the points of each.
    const large = (label, least) => {
      const members = new Map();
      for (let i = 0; i < count; i++) {
        if (label[i] < 0) continue;
        if (!members.has(label[i])) members.set(label[i], []);
        members.get(label[i]).push(i);
      }
      const kept = [];
      for (const some of members.values()) {
        const number = some.length < least ? LABELS.small : kept.push(some) - 1;
        for (const i of some) label[i] = number;
      }
      return kept;
    };

    // The smallest rectangle around points in a plane has a side on an edge of their hull.
    const boxAround = (some) => {
      const flat = some.map((i) => [at[3 * i], at[3 * i + 1]]).sort((p, q) => p[0] - q[0] || p[1] - q[1]);
      const bend = (o, p, q) => (p[0] - o[0]) * (q[1] - o[1]) - (p[1] - o[1]) * (q[0] - o[0]);
      const chainOf = (points) => {
        const chain = [];
        for (const point of points) {
          while (chain.length > 1 && bend(chain.at(-2), chain.at(-1), point) <= 0) chain.pop();
          chain.push(point);
        }
        return chain.slice(0, -1);
      };
      const hull = [flat[0], ...chainOf(flat).slice(1), ...chainOf(flat.reverse())];
      let least = Infinity, floor;
      hull.forEach((from, edge) => {
        const to = hull[(edge + 1) % hull.length], length = Math.hypot(to[0] - from[0], to[1] - from[1]);
        const c = length ? (to[0] - from[0]) / length : 1, s = length ? (to[1] - from[1]) / length : 0;
        const along = hull.map((p) => c * p[0] + s * p[1]), aside = hull.map((p) => c * p[1] - s * p[0]);
        const back = Math.min(...along), front = Math.max(...along);
        const right = Math.min(...aside), left = Math.max(...aside);
        if ((front - back) * (left - right) >= least) return;
        least = (front - back) * (left - right);
        floor = [[back, right], [front, right], [front, left], [back, left]]
          .map(([u, v]) => [c * u - s * v, s * u + c * v]);
      });
      let low = Infinity, high = -Infinity;
      for (const i of some) {
        low = Math.min(low, at[3 * i + 2]);
        high = Math.max(high, at[3 * i + 2]);
      }
      return [low, high].flatMap((z) => floor.flatMap(([x, y]) => [x, y, z]));
    };

    onmessage = ({ data }) => {
      if (data.xyz) {
        ({ xyz: at, step } = data);
        count = at.length / 3;
        return;
      }
      const [reach, distance, gap] = [data.ground, data.distance, data.threshold]
        .map((metres) => Math.round(metres / step));
      const [a, b, c] = findGround(reach), label = new Int32Array(count);
      let ground = 0, far = 0;
      for (let i = 0; i < count; i++) {
        const x = at[3 * i], y = at[3 * i + 1];
        if (at[3 * i + 2] - (a * x + b * y + c) <= reach) { label[i] = LABELS.ground; ground++; }
        else if (x * x + y * y > distance * distance) { label[i] = LABELS.far; far++; }
      }
      group(label, gap);
      const clusters = large(label, data.least), boxes = new Float32Array(clusters.flatMap(boxAround));
      const clustered = clusters.reduce((sum, some) => sum + some.length, 0);
      postMessage({ plane: [a, b, c], label, boxes, ground, far, clustered, clusters: clusters.length });
    };
  };

  // ---- the picture ---------------------------------------------------------------------------------
  const VERTEX = `
    attribute vec3 at; attribute vec4 before, after;
    uniform mat4 view; uniform float blend, size; varying vec4 colour;
    void main() {
      gl_Position = view * vec4(at, 1.0);
      gl_PointSize = clamp(size / gl_Position.w, 1.0, 8.0);
      colour = mix(before, after, blend);
    }`;
  const FRAGMENT = `
    precision mediump float; varying vec4 colour;
    void main() { gl_FragColor = vec4(colour.rgb * colour.a, colour.a); }`;
  const EDGES = [0, 1, 2, 3].flatMap((k) => [k, (k + 1) % 4, k + 4, ((k + 1) % 4) + 4, k, k + 4]);
  const HEIGHTS = { // colours from low to high, in each theme
    light: [[44, 30, 130], [150, 30, 150], [205, 80, 80], [200, 120, 10]],
    dark: [[100, 120, 240], [200, 90, 200], [240, 130, 90], [240, 230, 60]],
  };
  const HUES = [[0, 114, 178], [213, 94, 0], [0, 158, 115], [204, 121, 167], [230, 159, 0], [86, 180, 233]];
  const GREY = [128, 134, 142], GREEN = [0, 158, 115], LOWEST = -2.2, HIGHEST = 2.2; // metres
  const START = { heading: -2.3, height: 0.5, length: 32, target: [3, -1, -1] }; // radians and metres
  const LIMITS = { heading: [-7, 7], height: [0.03, 1.55], length: [3, 150] }; // of views
  const NEAREST = 0.3, FARTHEST = 500, DOT = 0.045, ANGLE = 0.75; // metres, and radians from top to bottom
  const TURN = 0.12, STAGE = 5, FADE = 0.8, LAST = 4; // radians per second, seconds, seconds, last stage

  const canvas = root.querySelector("canvas"), form = root.querySelector("form");
  const button = root.querySelector("button"), counts = root.querySelector(".counts");
  const sliders = [...form.querySelectorAll("input[type=range]")];
  const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
  const view = { ...START };
  let gl, place, buffers, xyz, step, colours, result, worker;
  let stage = still ? LAST : 0, moving = !still, visible = false, waiting = false;
  let busy = false, outdated = false, loaded = false; // the worker, its result, and the scan
  let lastFrame = 0, stageStart = 0, fadeStart = -Infinity, corners = 0, timer, writing;

  const prepare = () => {
    gl = canvas.getContext("webgl", { antialias: false }); // four times as fast without a graphics card
    if (!gl) return false;
    const program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    ["at", "before", "after"].forEach((name, number) => gl.bindAttribLocation(program, number, name));
    gl.linkProgram(program);
    gl.useProgram(program);
    gl.enable(gl.DEPTH_TEST);
    const named = (names, make) => Object.fromEntries(names.map((name) => [name, make(name)]));
    place = named(["view", "blend", "size"], (name) => gl.getUniformLocation(program, name));
    buffers = named(["points", "before", "after", "boxes"], () => gl.createBuffer());
    return true;
  };
  const fill = (name, data) => {
    gl.bindBuffer(gl.ARRAY_BUFFER, buffers[name]);
    gl.bufferData(gl.ARRAY_BUFFER, data, gl.DYNAMIC_DRAW);
  };
  const use = (number, name, size, kind, scaled) => {
    gl.bindBuffer(gl.ARRAY_BUFFER, buffers[name]);
    gl.enableVertexAttribArray(number);
    gl.vertexAttribPointer(number, size, kind, scaled, 0, 0);
  };

  // Faint points are transparent, so the background of the page shows through in each theme.
  const pack = ([r, g, b], opacity = 255) => (r | (g << 8) | (b << 16) | (opacity << 24)) >>> 0;
  const shades = () => {
    const ramp = HEIGHTS[document.documentElement.dataset.theme] ?? HEIGHTS.light;
    return Array.from({ length: 256 }, (_, level) => {
      const share = level / 85.1, from = Math.floor(share); // three parts
      return pack(ramp[from].map((k, n) => k + (ramp[from + 1][n] - k) * (share - from)));
    });
  };
  const colour = (fade) => {
    if (!xyz) return;
    const before = colours, height = shades(), hues = HUES.map((hue) => pack(hue));
    const ground = stage === 1 ? pack(GREEN) : pack(GREY, 40), far = pack(GREY, 60), small = pack(GREY, 150);
    colours = new Uint32Array(xyz.length / 3);
    for (let i = 0; i < colours.length; i++) {
      const label = stage > 0 && result ? result.label[i] : 0;
      if (label === LABELS.ground) colours[i] = ground;
      else if (label === LABELS.far && stage > 1) colours[i] = far;
      else if (stage > 2 && result) colours[i] = label === LABELS.small ? small : hues[label % hues.length];
      else {
        const level = ((xyz[3 * i + 2] * step - LOWEST) / (HIGHEST - LOWEST)) * 255;
        colours[i] = height[Math.max(0, Math.min(255, Math.round(level)))];
      }
    }
    fill("before", before ?? colours);
    fill("after", colours);
    fadeStart = fade && !still ? performance.now() : -Infinity;
    request();
  };

  const matrix = () => {
    const { heading, height, length, target } = view;
    const ahead = [-Math.cos(height) * Math.cos(heading), -Math.cos(height) * Math.sin(heading), -Math.sin(height)];
    const right = [-Math.sin(heading), Math.cos(heading), 0];
    const up = [ahead[2] * right[1], -ahead[2] * right[0], Math.cos(height)];
    const eye = target.map((middle, k) => middle - length * ahead[k]);
    const aspect = canvas.width / canvas.height, focal = Math.min(1, aspect / 1.5) / Math.tan(ANGLE / 2);
    const depth = (FARTHEST + NEAREST) / (FARTHEST - NEAREST);
    const scaled = (row, factor) => row.map((k) => k * factor);
    const rows = [scaled(right, focal / aspect), scaled(up, focal), scaled(ahead, depth), ahead];
    const moved = rows.map((row) => -row.reduce((sum, k, n) => sum + k * eye[n], 0));
    moved[2] -= (2 * FARTHEST * NEAREST) / (FARTHEST - NEAREST);
    return [...[0, 1, 2].flatMap((k) => rows.map((row) => row[k] * step)), ...moved];
  };
  const draw = (now) => {
    waiting = false;
    const seconds = Math.min(0.1, (now - lastFrame) / 1000);
    lastFrame = now;
    if (moving) {
      view.heading = (view.heading + TURN * seconds) % (2 * Math.PI);
      if (result && now - stageStart > STAGE * 1000) show((stage + 1) % (LAST + 1));
    }
    const blend = Math.min(1, Math.max(0, (now - fadeStart) / (FADE * 1000)));
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.uniformMatrix4fv(place.view, false, matrix());
    gl.uniform1f(place.blend, blend);
    gl.uniform1f(place.size, (DOT * canvas.height) / Math.tan(ANGLE / 2));
    use(0, "points", 3, gl.SHORT, false);
    use(1, "before", 4, gl.UNSIGNED_BYTE, true);
    use(2, "after", 4, gl.UNSIGNED_BYTE, true);
    gl.drawArrays(gl.POINTS, 0, xyz.length / 3);
    if (stage === LAST && corners) {
      const [r, g, b] = getComputedStyle(canvas).color.match(/[\d.]+/g).map((k) => k / 255);
      use(0, "boxes", 3, gl.FLOAT, false);
      for (const number of [1, 2]) {
        gl.disableVertexAttribArray(number);
        gl.vertexAttrib4f(number, r, g, b, number - 1);
      }
      gl.drawArrays(gl.LINES, 0, corners);
    }
    if (moving || blend < 1) setTimeout(rest, 0, performance.now());
  };
  // Without a graphics card, a frame blocks the page. Let the page work for as long before the next one.
  const rest = (drawn) => {
    const blocked = performance.now() - drawn;
    setTimeout(request, blocked > 30 ? blocked : 0);
  };
  const request = () => {
    if (waiting || !visible || !xyz) return;
    waiting = true;
    requestAnimationFrame(draw);
  };

  // ---- words and controls --------------------------------------------------------------------------
  const say = (number, noun) => `${number.toLocaleString("en")} ${noun}${number === 1 ? "" : "s"}`;
  const tell = () => {
    if (!result) return;
    const all = result.label.length, { ground, far, clustered, clusters } = result;
    const found = `${say(clustered, "point")} in ${say(clusters, "cluster")}`;
    const texts = [
      `${say(all, "point")} from one turn of the scanner, coloured by height`,
      `${say(ground, "point")} on the ground, ${say(all - ground, "point")} above it`,
      `${say(all - ground - far, "nearby point")} above the ground`,
      `${found}, and ${say(all - ground - far - clustered, "point")} in smaller clusters`,
      `${found}, with a box around each cluster`,
    ];
    // Screen readers read each change, so a slider that is being moved does not change the text.
    clearTimeout(timer);
    timer = setTimeout(() => { counts.textContent = texts[stage]; }, 250);
  };
  const show = (number) => {
    stage = number;
    stageStart = performance.now();
    form.elements.stage.value = number;
    tell();
    colour(true);
  };
  const move = (on) => {
    moving = on;
    button.textContent = on ? "Pause" : "Play";
    counts.setAttribute("aria-live", on ? "off" : "polite");
    stageStart = lastFrame = performance.now();
    request();
  };
  const describe = (slider) => {
    const { unit } = slider.dataset, value = `${slider.value} ${unit}`;
    slider.parentElement.querySelector("b").textContent = value;
    slider.setAttribute("aria-valuetext", value);
  };
  // While the worker computes, only the newest position of the sliders is kept.
  const ask = () => {
    outdated = busy;
    if (busy || !xyz) return;
    busy = true;
    worker.postMessage(Object.fromEntries(sliders.map((slider) => [slider.name, +slider.value])));
  };
  const receive = ({ data }) => {
    busy = false;
    if (!result) stageStart = performance.now();
    result = data;
    root.dataset.plane = data.plane.join(" "); // for tests/site_in_browser.py
    const ends = [];
    for (let box = 0; box < data.boxes.length; box += 24) {
      for (const corner of EDGES) ends.push(...data.boxes.subarray(box + 3 * corner, box + 3 * corner + 3));
    }
    corners = ends.length / 3;
    fill("boxes", new Float32Array(ends));
    tell();
    colour(false);
    if (outdated) ask();
  };

  // ---- the view in the address ---------------------------------------------------------------------
  // Once the reader has moved something, the address has the camera, the stage and the sliders.
  const write = () => { // once the view rests, because browsers limit how often an address changes
    clearTimeout(writing);
    writing = setTimeout(() => {
      const camera = Object.keys(LIMITS).map((name) => [name, view[name].toFixed(2)]);
      const values = sliders.map(({ name, value }) => [name, value]);
      const parts = new URLSearchParams([...camera, ["stage", stage], ...values]);
      history.replaceState(history.state, "", `#${parts}`);
    }, 300);
  };
  const openAddress = () => {
    const found = Object.fromEntries(new URLSearchParams(location.hash.slice(1)));
    const isWithin = (name, least, most) => +found[name] >= least && +found[name] <= most;
    const isView = Object.entries(LIMITS).every(([name, limits]) => isWithin(name, ...limits))
      && /^[0-4]$/.test(found.stage) && sliders.every(({ name, min, max }) => isWithin(name, min, max));
    if (!isView) return;
    for (const name of Object.keys(LIMITS)) view[name] = +found[name];
    for (const slider of sliders) { slider.value = found[slider.name]; describe(slider); }
    move(false);
    show(+found.stage);
    ask();
    root.scrollIntoView({ block: "nearest" });
  };

  const clip = (name, number) => Math.max(LIMITS[name][0], Math.min(LIMITS[name][1], number));
  const stop = () => { move(false); write(); };
  const turn = (across, down) => {
    view.heading = (view.heading - across) % (2 * Math.PI);
    view.height = clip("height", view.height + down);
    stop();
  };
  const zoom = (factor) => {
    view.length = clip("length", view.length * factor);
    stop();
  };
  const fingers = new Map();
  const listen = () => {
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      fingers.set(event.pointerId, event);
    });
    canvas.addEventListener("pointermove", (event) => {
      const before = fingers.get(event.pointerId);
      if (!before) return;
      fingers.set(event.pointerId, event);
      const other = [...fingers.values()].find((finger) => finger !== event);
      const span = (finger) => Math.hypot(finger.clientX - other.clientX, finger.clientY - other.clientY) || 1;
      if (other) zoom(span(before) / span(event));
      else turn((event.clientX - before.clientX) * 0.008, (event.clientY - before.clientY) * 0.008);
    });
    for (const name of ["pointerup", "pointercancel"]) {
      canvas.addEventListener(name, (event) => fingers.delete(event.pointerId));
    }
    canvas.addEventListener("wheel", (event) => {
      if (document.activeElement !== canvas) return; // before a click, the wheel scrolls the page
      event.preventDefault();
      zoom(Math.exp(Math.max(-100, Math.min(100, event.deltaY)) * 0.002));
    }, { passive: false });
    canvas.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      const arrow = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] }[event.key];
      const factor = { "+": 1 / 1.15, "=": 1 / 1.15, "-": 1.15 }[event.key];
      if (arrow) turn(...arrow);
      else if (factor) zoom(factor);
      else if (event.key === "0") { Object.assign(view, START); stop(); }
      else return;
      event.preventDefault();
    });
    form.addEventListener("submit", (event) => event.preventDefault());
    form.addEventListener("input", ({ target }) => {
      stop();
      if (target.type === "radio") { show(+target.value); return; }
      describe(target);
      if (stage < +target.dataset.stage) show(+target.dataset.stage);
      ask();
    });
    button.addEventListener("click", () => (moving ? stop() : move(true)));
    canvas.addEventListener("webglcontextlost", showFilm);
    new ResizeObserver(() => {
      const scale = Math.min(2, devicePixelRatio);
      canvas.width = Math.max(2, Math.round(canvas.clientWidth * scale));
      canvas.height = Math.max(2, Math.round(canvas.clientHeight * scale));
      request();
    }).observe(canvas);
    addEventListener("hashchange", openAddress);
    const theme = new MutationObserver(() => colour(false));
    theme.observe(document.documentElement, { attributeFilter: ["data-theme"] });
  };

  // ---- the scan, or the film -----------------------------------------------------------------------
  const showFilm = () => {
    const instead = document.querySelector("noscript.film");
    if (!instead) return;
    root.remove();
    instead.outerHTML = instead.textContent;
    const film = document.querySelector("figure.film img");
    if (still) return;
    const moved = film.getAttribute("src"), halt = document.createElement("button");
    halt.type = "button";
    halt.textContent = "Pause the film";
    halt.addEventListener("click", () => {
      const halted = film.getAttribute("src") !== moved;
      film.setAttribute("src", halted ? moved : film.dataset.still);
      halt.textContent = halted ? "Pause the film" : "Play the film";
    });
    film.closest("figure").append(halt);
  };
  const open = () => {
    step = SCAN.step;
    const text = atob(SCAN.xyz), bytes = new Uint8Array(text.length);
    for (let k = 0; k < text.length; k++) bytes[k] = text.charCodeAt(k);
    xyz = new Int16Array(bytes.buffer);
    const code = `const LABELS = ${JSON.stringify(LABELS)}; (${work})()`;
    worker = new Worker(URL.createObjectURL(new Blob([code], { type: "text/javascript" })));
    worker.onmessage = receive;
    worker.onerror = showFilm;
    worker.postMessage({ xyz, step });
    fill("points", xyz);
    colour(false);
    ask();
  };
  const load = () => {
    const script = document.createElement("script");
    script.src = root.dataset.scan;
    script.onload = open;
    script.onerror = showFilm;
    document.head.append(script);
  };

  if (!prepare()) { showFilm(); return; }
  sliders.forEach(describe);
  form.elements.stage.value = stage;
  move(moving);
  listen();
  openAddress();
  const observe = () => new IntersectionObserver(([entry]) => {
    visible = entry.isIntersecting;
    if (visible && !loaded) { loaded = true; load(); }
    request();
  }).observe(canvas);
  if (document.readyState === "complete") observe();
  else addEventListener("load", observe); // the page comes first
})();
