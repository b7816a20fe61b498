// Stores guesses in the browser and shows them next to the answers, and makes content wider than the
// page accessible from the keyboard.
(() => {
  const key = (question) => `guess-${question}`;
  const known = (question) => { try { return localStorage.getItem(key(question)); } catch { return null; } };
  const keep = (question, guess) => { try { localStorage.setItem(key(question), guess); } catch { /* do not store the guess */ } };

  const tell = (question, guess) => {
    for (const answer of document.querySelectorAll(`details.answer[data-question="${question}"] .yours`)) {
      answer.textContent = guess ? `Your guess: ${guess}` : "";
    }
  };

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

  const reach = () => {
    for (const wide of document.querySelectorAll('mjx-container[display="true"], .cell_output .output')) {
      if (wide.scrollWidth > wide.clientWidth) wide.tabIndex = 0;
    }
  };
  addEventListener("load", () => {
    (window.MathJax?.startup?.promise ?? Promise.resolve()).then(reach);
  });
  addEventListener("resize", reach);

  for (const report of document.querySelectorAll("a.report")) {
    report.addEventListener("click", () => {
      const place = location.hash ? `${document.title}, ${location.hash}` : document.title;
      report.href = `${report.href.split("?")[0]}?title=${encodeURIComponent(place)}`;
    });
  }
})();
