// Stores guesses in the browser and shows them next to the answers, shows the reader's progress, keeps
// the cameras of scenes in the address, and makes content wider than the page accessible from the
// keyboard.
(() => {
  const stored = (name) => { try { return localStorage.getItem(name); } catch { return null; } };
  const store = (name, text) => { try { localStorage.setItem(name, text); } catch { /* the browser refuses */ } };
  const known = (question) => stored(`guess-${question}`);
  const keep = (question, guess) => store(`guess-${question}`, guess);

  const tell = (question, guess) => {
    for (const answer of document.querySelectorAll(`details.answer[data-question="${question}"] .yours`)) {
      answer.textContent = guess ? `Your guess: ${guess}` : "";
    }
  };

  // A lesson's page shows its progress below the links, and the front page on the lesson's card.
  const lessonAt = (address) => new URL(address, location).pathname.split("/").pop().replace(".html", "");
  const questions = [...document.querySelectorAll("form.guess")].map((form) => form.dataset.question);
  const progress = document.createElement("p");
  progress.className = "progress-so-far";
  document.querySelector("nav.run")?.after(progress);
  const showProgress = () => {
    const lesson = lessonAt(location);
    const guessed = questions.filter((question) => known(question) !== null).length;
    const passed = JSON.parse(stored(`passed-${lesson}`) ?? "[]").length;
    const parts = [];
    if (guessed) parts.push(`${guessed} of ${questions.length} guesses made`);
    if (passed) parts.push(`${passed} ${passed === 1 ? "exercise" : "exercises"} passed`);
    if (!parts.length) return;
    progress.textContent = `So far: ${parts.join(", ")}.`;
    store(`progress-${lesson}`, parts.join(", "));
  };
  showProgress();
  document.addEventListener("exercise-passed", showProgress); // from live.js
  for (const card of document.querySelectorAll("a.lesson-card")) {
    const text = stored(`progress-${lessonAt(card.href)}`);
    if (!text) continue;
    const line = document.createElement("b");
    line.textContent = ` · ${text}`;
    card.querySelector(".about").append(line);
  }

  for (const form of document.querySelectorAll("form.guess")) {
    const question = form.dataset.question;
    const output = form.querySelector("output");
    const shown = (value) => (output ? `${value}${output.dataset.suffix}` : value);
    const guess = known(question);
    if (guess) {
      for (const field of form.querySelectorAll("input")) {
        if (field.type === "radio") field.checked = field.value === guess;
        else field.value = guess;
      }
      if (output) output.textContent = shown(guess);
      tell(question, shown(guess));
    }
    form.addEventListener("input", (event) => {
      const value = event.target.value;
      keep(question, value);
      if (output) output.textContent = shown(value);
      tell(question, shown(value));
      showProgress();
    });
    form.addEventListener("submit", (event) => event.preventDefault());
  }

  for (const code of document.querySelectorAll("div.cell_input div.highlight, div.highlight-sh div.highlight")) {
    if (!navigator.clipboard) break; // browsers offer it only on https and on this machine
    const button = document.createElement("button");
    button.type = "button";
    button.className = "copy";
    button.textContent = "Copy";
    button.addEventListener("click", async () => {
      await navigator.clipboard.writeText(code.querySelector("pre").textContent);
      button.textContent = "Copied";
      setTimeout(() => (button.textContent = "Copy"), 2000);
    });
    code.append(button);
  }

  // A browser may begin a line with the comma after a formula.
  for (const formula of document.querySelectorAll("span.math")) {
    const mark = formula.nextSibling;
    const [start] = /^[.,;:?!)]+/.exec(mark?.nodeType === Node.TEXT_NODE ? mark.data : "") ?? [];
    if (!start) continue;
    mark.splitText(start.length);
    const unbroken = document.createElement("span");
    unbroken.className = "unbroken";
    formula.before(unbroken);
    unbroken.append(formula, mark);
  }

  // A short name moves to the next line. A long one breaks after an underscore, not within a word.
  for (const name of document.querySelectorAll(".bd-article code.literal .pre")) {
    if (name.textContent.length < 16) name.classList.add("unbroken");
    if (name.getClientRects().length < 2) continue;
    for (const underscore of [...name.textContent.matchAll(/_(?=.)/g)].reverse()) {
      name.firstChild.splitText(underscore.index + 1).before(document.createElement("wbr"));
    }
  }

  // The address keeps the cameras of the scenes that the reader has moved, by their number on the page.
  // Each scene is a page in a frame, and sends its camera when the reader has moved it.
  const scenes = new Map([...document.querySelectorAll("iframe.scene")].map(
    (frame, index) => [`scene-${index + 1}`, frame]));
  const cameras = new Map(); // the scene that was moved last is at the end
  const send = (name) => {
    if (cameras.has(name)) scenes.get(name).contentWindow.postMessage({ camera: cameras.get(name) }, "*");
  };
  const openAddress = () => {
    const found = [...new URLSearchParams(location.hash.slice(1))].filter(([name]) => scenes.has(name));
    for (const [name, camera] of found) {
      cameras.set(name, camera);
      send(name);
    }
    if (found.length) scenes.get(found.at(-1)[0]).scrollIntoView({ block: "center" });
  };
  for (const [name, frame] of scenes) frame.addEventListener("load", () => send(name));
  addEventListener("hashchange", openAddress);
  addEventListener("message", ({ source, data }) => {
    const [name] = [...scenes].find(([, frame]) => frame.contentWindow === source) ?? [];
    if (!name || !data?.camera) return;
    cameras.delete(name);
    cameras.set(name, data.camera);
    history.replaceState(history.state, "", `#${[...cameras].map((pair) => pair.join("=")).join("&")}`);
  });

  const reach = () => {
    for (const wide of document.querySelectorAll('mjx-container[display="true"], .cell_output .output')) {
      if (wide.scrollWidth > wide.clientWidth) wide.tabIndex = 0;
    }
  };
  addEventListener("load", () => {
    (window.MathJax?.startup?.promise ?? Promise.resolve()).then(() => { reach(); openAddress(); });
  });
  addEventListener("resize", reach);

  for (const report of document.querySelectorAll("a.report")) {
    report.addEventListener("click", () => {
      const place = location.hash ? `${document.title}, ${location.hash}` : document.title;
      report.href = `${report.href.split("?")[0]}?title=${encodeURIComponent(place)}`;
    });
  }
})();
