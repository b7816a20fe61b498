// Run and Check under each exercise: an editor, Python in a Web Worker, and the notebook to hand in.
// Sliders, which show prepared pictures, compute new ones while Python runs.
//
// Nothing is loaded before the reader opens an editor, and Python not before they press a button.
(() => {
  const here = document.currentScript;
  const folder = new URL(".", here.src);
  const { lesson, python, library, bytes } = here.dataset;
  const size = `${(bytes / 1e6).toFixed(0)} MB`;
  // Calls a function with each cell of a kind on the page, and the cell's id.
  const forEachCell = (kind, act) => {
    for (const cell of document.querySelectorAll(`div.cell[class*=tag_${kind}-]`)) {
      const tag = [...cell.classList].find((name) => name.startsWith(`tag_${kind}-`));
      act(cell, tag.slice(`tag_${kind}-`.length));
    }
  };
  const key = (id) => `code-${lesson}-${id}`;
  // The reader's code, by exercise. A browser may refuse to store it; then it lasts as long as the page.
  const written = new Map();
  const known = (id) => {
    if (!written.has(id)) try { written.set(id, localStorage.getItem(key(id))); } catch { return null; }
    return written.get(id);
  };
  const keep = (id, text) => { written.set(id, text); try { localStorage.setItem(key(id), text); } catch { /* see above */ } };
  const keepPassed = (id) => {
    try {
      const name = `passed-${lesson}`;
      const passed = new Set(JSON.parse(localStorage.getItem(name) ?? "[]"));
      localStorage.setItem(name, JSON.stringify([...passed.add(id)]));
    } catch { return; }
    document.dispatchEvent(new Event("exercise-passed")); // site.js shows the progress
  };
  const forget = (id) => { written.set(id, null); try { localStorage.removeItem(key(id)); } catch { /* see above */ } };
  const element = (tag, attributes = {}, ...children) => {
    const made = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    made.append(...children);
    return made;
  };
  const button = (name, text, act) => {
    const made = element("button", { type: "button", class: name }, text);
    made.addEventListener("click", act);
    return made;
  };
  const sourceOf = (cell) => (Array.isArray(cell.source) ? cell.source.join("") : cell.source);
  const isCode = (cell) => cell.cell_type === "code";
  // Readers also write in the cell for their functions of earlier lessons.
  const isExercise = (cell) => cell.metadata.nbgrader?.solution || cell.metadata.tags?.includes("earlier");
  const isCheck = (cell) => cell.metadata.nbgrader?.grade && !isExercise(cell);
  const textOf = (cell) => (isExercise(cell) ? known(cell.id) ?? sourceOf(cell) : sourceOf(cell));

  // --- files of the site ------------------------------------------------------------------------

  const once = (load) => { let promise; return () => (promise ??= load()); };
  const notebook = once(async () => (await fetch(new URL(`../notebooks/${lesson}.ipynb`, folder))).json());
  const editorScript = once(() => new Promise((resolve, reject) => {
    const script = element("script", { src: new URL("editor.js", folder) });
    script.onload = resolve;
    script.onerror = () => reject(new Error("The editor did not load."));
    document.head.append(script);
  }));

  // --- the session: one worker, which runs one cell after another ---------------------------------

  class Stopped extends Error {}
  let worker = null;
  let busy = false;
  let answer = null; // {resolve, reject, receive} of the message that the worker is answering
  let ran = new Map(); // the source with which each cell ran in this session, by the cell's id
  const panels = []; // parts of the page that show whether the worker is busy
  const setBusy = (is) => {
    busy = is;
    for (const panel of panels) panel.setBusy(is);
  };

  const ask = (message, receive) => new Promise((resolve, reject) => {
    answer = { resolve, reject, receive };
    worker.postMessage(message);
  });
  const fail = (error) => {
    answer?.reject(error);
    answer = null;
  };
  const end = () => {
    worker?.terminate();
    worker = null;
    ran = new Map();
  };
  const startPython = async (tell) => {
    worker = new Worker(new URL("worker.js", folder));
    worker.onmessage = ({ data }) => {
      if (data.kind === "failed") fail(new Error(data.text));
      else if (data.kind === "ready" || data.kind === "done") answer?.resolve(data);
      else answer?.receive?.(data);
    };
    worker.onerror = (event) => fail(new Error(event.message));
    tell(`Loading Python, ${size}`);
    await ask({ python, library }, ({ kind, loaded }) => {
      if (kind !== "loading") return;
      const share = Math.min(100, Math.round((100 * loaded) / bytes));
      tell(share < 100 ? `Loading Python: ${share} % of ${size}` : "Starting Python");
    });
  };
  // Runs a cell. Without `show`, it runs quietly, and only errors that the lesson does not expect are
  // passed to `warn`.
  const runCell = async (cell, source, show, warn) => {
    const errors = [];
    const { ok } = await ask({ source, quietly: !show }, show ?? ((message) => {
      if (message.kind === "error") errors.push(message);
    }));
    ran.set(cell.id, source);
    if (!cell.metadata.tags?.includes("raises-exception")) errors.forEach((message) => warn(message));
    return ok;
  };
  // Runs the cells that have not run with their present source; returns whether the last one succeeded.
  const runAbove = async (cells, tell, warn) => {
    const above = cells.filter((cell) => isCode(cell) && !isCheck(cell) && ran.get(cell.id) !== textOf(cell));
    let ok = true;
    for (const [index, cell] of above.entries()) {
      tell(`Running the cells above: ${index + 1} of ${above.length}`);
      ok = await runCell(cell, textOf(cell), null, warn);
      if (!ok && cell.metadata.tags?.includes("setup")) throw new Error("The course's tools did not load.");
    }
    return ok;
  };
  // Starts Python if needed, and runs code; `act` returns what to tell the reader at the end.
  const work = async (tell, act) => {
    setBusy(true);
    try {
      if (!worker) {
        await startPython(tell);
        for (const panel of panels) panel.started?.();
      }
      tell(await act());
    } catch (error) {
      if (error instanceof Stopped) tell("Stopped. Your code is kept, and Run starts Python again.");
      else if (ran.size) tell(`Python ended. ${error.message} Your code is kept, and Run starts Python again.`);
      else tell(`Python cannot start. ${error.message} It needs Chrome 137, Firefox 131, Safari 18.4, or a newer version.`);
      end();
    }
    setBusy(false);
  };

  // --- outputs --------------------------------------------------------------------------------------

  // Removes scripts from HTML that Python made. Scenes keep theirs, in a frame of their own.
  const withoutScripts = (html) => {
    const { body } = new DOMParser().parseFromString(html, "text/html");
    for (const node of body.querySelectorAll("script, style, link, meta, base, object, embed, form")) node.remove();
    for (const node of body.querySelectorAll("*")) {
      for (const { name, value } of [...node.attributes]) {
        const isAddress = /^(src|href|xlink:href|action|formaction|srcset|data|poster)$/.test(name);
        if (name.startsWith("on") || (isAddress && !/^(#|data:image\/)/.test(value))) node.removeAttribute(name);
      }
    }
    for (const frame of body.querySelectorAll("iframe")) {
      frame.setAttribute("sandbox", "allow-scripts");
      frame.className = "scene";
    }
    return [...body.childNodes];
  };
  const overwritten = (text) => text.replace(/[^\n]*\r(?!\n)/g, "");

  // Returns a function that adds the worker's messages to a box on the page.
  const shownIn = (box, alt = "The figure that this code draws.") => {
    const displays = new Map();
    const added = (kind, ...children) => {
      const output = element("div", { class: `output ${kind}` }, ...children);
      box.append(element("div", { class: "cell_output docutils container" }, output));
      return output;
    };
    return (message) => {
      if (message.kind === "stream") {
        const last = box.lastElementChild?.querySelector(":scope > .output > pre[data-stream]");
        if (last) last.textContent = overwritten(last.textContent + message.text);
        else added("stream").append(element("pre", { "data-stream": "", tabindex: "0" }, overwritten(message.text)));
      } else if (message.kind === "error") {
        added("error").append(element("pre", { tabindex: "0" }, message.text));
      } else if (message.kind === "clear") {
        box.replaceChildren();
      } else if (message.kind === "display") {
        let content;
        if (message.type === "text/html") content = withoutScripts(message.data);
        else if (message.type.startsWith("image/")) {
          content = [element("img", { src: `data:${message.type};base64,${message.data}`, alt })];
        } else content = [element("pre", { tabindex: "0" }, message.data)];
        const earlier = message.update && displays.get(message.id);
        if (earlier) earlier.replaceChildren(...content);
        else {
          const output = added(message.type === "text/html" ? "text_html" : "text_plain", ...content);
          if (message.id) displays.set(message.id, output);
        }
      }
    };
  };

  // --- one exercise -----------------------------------------------------------------------------------

  const openPanel = async (place, id, name) => {
    const [{ cells }] = await Promise.all([notebook(), editorScript()]);
    const position = cells.findIndex((cell) => cell.id === id);
    const stub = sourceOf(cells[position]);
    const rest = cells.slice(position + 1);
    const following = rest.slice(0, Math.max(0, rest.findIndex((cell) => isExercise(cell) || isCheck(cell)))).filter(isCode);
    const check = rest.find((cell) => isExercise(cell) || isCheck(cell));
    const hasCheck = check && isCheck(check);

    const state = element("p", { class: "state", role: "status" });
    const outputs = element("div", { class: "outputs" });
    const tell = (text) => { state.textContent = text; };
    const box = element("div", { class: "editor" });
    const editor = createEditor({
      parent: box,
      text: known(id) ?? stub,
      label: `Your code for ${name}. Press Escape and then Tab to leave the editor.`,
      changed: (text) => (text === stub ? forget(id) : keep(id, text)),
    });

    // Runs the cells above, then this exercise.
    const run = (checking) => {
      if (busy) return;
      outputs.replaceChildren();
      const show = shownIn(outputs);
      work(tell, async () => {
        await runAbove(cells.slice(0, position), tell, show);
        tell("Running your code");
        const isNew = ran.get(id) !== textOf(cells[position]);
        let ok = await runCell(cells[position], textOf(cells[position]), show);
        if (ok) {
          for (const cell of following) {
            if (!checking) await runCell(cell, textOf(cell), show);
            else if (isNew || !ran.has(cell.id)) await runCell(cell, textOf(cell), null, show);
          }
          if (checking) {
            tell("Checking");
            ok = await runCell(check, sourceOf(check), show);
            const card = outputs.textContent;
            if (ok && card.includes("✓ passed") && !/✗ failed|… waiting/.test(card)) keepPassed(id);
          }
        }
        return checking ? "Checked." : ok ? "Done." : "Your code has an error.";
      });
    };

    const buttons = {
      run: button("run", "Run", () => run(false)),
      check: button("check", "Check", () => run(true)),
      stop: button("stop", "Stop", () => fail(new Stopped())),
      reset: button("reset", "Restore the stub", () => {
        if (confirm("Replace your code with the stub?")) editor.replace(stub);
      }),
      download: button("download", "Download my notebook", download),
    };
    if (!hasCheck) buttons.check.remove();
    buttons.stop.disabled = true;
    panels.push({
      setBusy: (is) => {
        buttons.run.disabled = buttons.check.disabled = is;
        buttons.stop.disabled = !is;
      },
    });
    if (!worker) tell(`The first time, Run and Check download Python from this website (${size}). Your browser keeps it.`);
    const row = element("div", { class: "buttons" }, buttons.run, ...(hasCheck ? [buttons.check] : []),
      buttons.stop, buttons.reset, buttons.download);
    place.replaceChildren(box, row, state, outputs);
    place.previousElementSibling.hidden = true; // the stub, which the editor replaces
    if (busy) panels.at(-1).setBusy(true);
  };

  // Saves the released notebook with the reader's code, under the same cell ids and metadata.
  const download = async () => {
    const content = structuredClone(await notebook());
    for (const cell of content.cells) {
      const text = isExercise(cell) && known(cell.id);
      if (text) cell.source = text.split(/(?<=\n)/);
    }
    const file = new Blob([`${JSON.stringify(content, null, 1)}\n`], { type: "application/x-ipynb+json" });
    const link = element("a", { href: URL.createObjectURL(file), download: `${lesson}.ipynb` });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
  };

  // --- sliders --------------------------------------------------------------------------------------------

  // Adds sliders to prepared pictures. A moved slider calls the function of its cell.
  const addSliders = (cell, id) => {
    const place = cell.querySelector("fieldset.positions");
    const { name, parameters } = JSON.parse(place.dataset.call);
    const state = element("p", { class: "state", role: "status" });
    const outputs = element("div", { class: "outputs" });
    const tell = (text) => { state.textContent = text; };
    const inputs = parameters.map(({ values, start }) => element("input", { type: "range", max: values.length - 1, value: start }));
    const valueAt = (index) => parameters[index].values[inputs[index].value];
    let isOutdated = false;

    const compute = () => {
      isOutdated = busy;
      if (busy) return;
      const values = parameters.map((parameter, index) => `${parameter.name}=${valueAt(index)}`).join(", ");
      const box = element("div");
      const show = shownIn(box, `The figure with ${values}.`);
      work(tell, async () => {
        const { cells } = await notebook();
        const position = cells.findIndex((notebookCell) => notebookCell.id === id);
        let ok = await runAbove(cells.slice(0, position + 1), tell, show);
        tell("Computing");
        if (ok) ({ ok } = await ask({ source: `${name}(${values})` }, show));
        else ran.delete(id);
        outputs.replaceChildren(box);
        place.classList.toggle("computed", ok);
        return ok ? `Computed with ${values}.` : "The picture below was prepared with the course's answer.";
      });
    };

    const row = element("div", { class: "sliders" }, ...inputs.map((input, index) => {
      const value = element("b");
      const describe = () => {
        value.textContent = valueAt(index);
        input.setAttribute("aria-valuetext", valueAt(index));
      };
      describe();
      input.addEventListener("input", describe);
      input.addEventListener("change", compute);
      return element("label", {}, `${parameters[index].title} `, value, input);
    }));
    const stop = button("stop", "Stop", () => fail(new Stopped()));
    const open = button("open", "Choose any value", compute);
    stop.hidden = row.hidden = true;
    tell(`The first time, this downloads Python from this website (${size}). Your browser keeps it.`);
    panels.push({
      started: () => {
        if (!row.hidden) return;
        const isHere = document.activeElement === open;
        row.hidden = false;
        open.remove();
        if (isHere) inputs[0].focus();
        tell("Move a slider, and Python computes the picture.");
        place.querySelector("input.at-0").checked = true; // the sliders begin with the lesson's values
      },
      setBusy: (is) => {
        stop.hidden = !is;
        if (!is && isOutdated) setTimeout(compute);
      },
    });
    place.querySelector("legend").after(element("div", { class: "live" }, open, row, stop, state), outputs);
  };

  // --- the page -----------------------------------------------------------------------------------------------

  const isServed = location.protocol !== "file:";
  if (isServed) forEachCell("sliders", addSliders);
  forEachCell("exercise", (cell, id) => {
    const name = cell.classList.contains("tag_earlier") ? "the functions of earlier lessons" : id;
    const place = element("div", { class: "live", role: "group", "aria-label": `Write ${name}` });
    cell.querySelector(".cell_input").after(place);
    if (!isServed) {
      place.append(element("p", {}, "Your code can run in this page only if the page comes from a web server. "
        + "If you opened the page from a disk, download the notebook."));
      return;
    }
    const open = () => openPanel(place, id, name).catch((error) => { place.append(element("p", { role: "alert" }, error.message)); });
    place.append(button("open", "Write and run it here", open));
    if (known(id) !== null) open();
  });
})();
