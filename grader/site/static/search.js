// Adds the best matching sections, each with a line of its text, below each page that Sphinx's search
// finds. The text of the sections is in a script, because a page opened from a disk cannot fetch files.
(() => {
  const query = new URLSearchParams(location.search).get("q");
  const results = document.getElementById("search-results");
  if (!query || !results) return;

  // Sphinx's own sentence speaks of categories, which this site does not have.
  Documentation.TRANSLATIONS[
    "Your search did not match any documents. Please make sure that all words are spelled " +
      "correctly and that you've selected enough categories."
  ] = "No page contains these words.";

  const WORD = /[\p{L}\p{N}]+/gu; // a name such as iterations_needed is several words
  const WINDOW = 12; // words within which terms count as close together
  const stemmer = new Stemmer();
  const stems = new Map();
  const stem = (word) => {
    if (!stems.has(word)) stems.set(word, stemmer.stemWord(word.toLowerCase()));
    return stems.get(word);
  };
  const wordsOf = (text) => text.match(WORD) ?? [];
  const asked = wordsOf(query).map((word) => word.toLowerCase());
  const important = asked.filter((word) => !stopwords.has(word));
  const terms = new Set(important.map(stem));
  const termsIn = (text) => new Set(wordsOf(text).map(stem).filter((word) => terms.has(word))).size;

  // Finds the part of a section that contains most of the terms close together.
  const scored = ([page, anchor, title, text, code]) => {
    const words = [...text.matchAll(WORD)];
    const hits = words.flatMap((word, number) => (terms.has(stem(word[0])) ? [number] : []));
    let best = { terms: 0, from: 0 };
    hits.forEach((first, place) => {
      const near = hits.slice(place).filter((number) => number < first + WINDOW);
      const found = new Set(near.map((number) => stem(words[number][0]))).size;
      if (found > best.terms) best = { terms: found, from: first };
    });
    const from = words[Math.max(0, best.from - WINDOW / 2)];
    const to = words[Math.min(words.length - 1, best.from + 2 * WINDOW)];
    return {
      page, anchor, title,
      line: text.slice(from.index, to.index + to[0].length),
      // A heading says what its section is about, so it counts most.
      score: 6 * termsIn(title) + 4 * best.terms + termsIn(text) + termsIn(code),
    };
  };
  const found = SECTIONS.filter(([, , , text]) => wordsOf(text).length)
    .map(scored)
    .filter((section) => section.score > 0);
  found.sort((a, b) => b.score - a.score);

  const shown = (section) => {
    const item = document.createElement("li");
    const link = item.appendChild(document.createElement("a"));
    link.href = `${section.page}#${section.anchor}`;
    link.textContent = section.title;
    const line = item.appendChild(document.createElement("p"));
    for (const part of `… ${section.line} …`.split(/([\p{L}\p{N}]+)/u)) {
      const hit = part && terms.has(stem(part));
      line.append(hit ? Object.assign(document.createElement("mark"), { textContent: part }) : part);
    }
    return item;
  };

  // Returns the number of letters to insert, remove, replace or swap, or 3 if it is more than 2.
  const difference = (first, second) => {
    if (Math.abs(first.length - second.length) > 2) return 3;
    const rows = [[...second, ""].map((_, column) => column)];
    for (let i = 1; i <= first.length; i++) {
      rows.push([i]);
      for (let j = 1; j <= second.length; j++) {
        const same = first[i - 1] === second[j - 1];
        rows[i][j] = Math.min(rows[i - 1][j] + 1, rows[i][j - 1] + 1, rows[i - 1][j - 1] + !same);
        if (i > 1 && j > 1 && first[i - 1] === second[j - 2] && first[i - 2] === second[j - 1])
          rows[i][j] = Math.min(rows[i][j], rows[i - 2][j - 2] + 1);
      }
    }
    return Math.min(3, rows[first.length][second.length]);
  };

  // Replaces each word that the course does not contain by the most frequent similar word.
  const corrected = () => {
    const counts = new Map();
    for (const [, , title, text] of SECTIONS)
      for (const word of wordsOf(`${title} ${text}`.toLowerCase()))
        counts.set(word, (counts.get(word) ?? 0) + 1);
    const known = new Set([...counts.keys()].map(stem));
    return asked.map((word) => {
      if (word.length < 4 || known.has(stem(word))) return word;
      const similar = [...counts.keys()]
        .map((other) => [difference(word, other), -counts.get(other), other])
        .filter(([letters]) => letters <= (word.length < 6 ? 1 : 2));
      similar.sort((a, b) => a[0] - b[0] || a[1] - b[1]);
      return similar[0]?.[2] ?? word;
    });
  };
  const better = corrected();
  if (better.join() !== asked.join()) {
    const line = document.createElement("p");
    line.className = "did-you-mean";
    const link = Object.assign(document.createElement("a"), {
      href: `?q=${encodeURIComponent(better.join(" "))}`,
      textContent: better.join(" "),
    });
    line.append("Did you mean ", link, "?");
    results.before(line);
  }

  const arrange = () => {
    watch.disconnect();
    const list = results.querySelector("ul.search");
    const score = (item) => Number(item.dataset.best ?? 0);
    for (const item of list?.querySelectorAll(":scope > li:not([data-best])") ?? []) {
      const page = item.querySelector("a").getAttribute("href").split("#")[0];
      const sections = found.filter((section) => section.page === page).slice(0, 3);
      item.dataset.best = sections[0]?.score ?? 0;
      if (sections.length) {
        const inner = item.appendChild(document.createElement("ul"));
        inner.className = "sections";
        inner.append(...sections.map(shown));
      }
    }
    list?.append(...[...list.children].sort((a, b) => score(b) - score(a)));
    watch.observe(results, { childList: true, subtree: true });
  };
  let soon;
  const watch = new MutationObserver(() => {
    clearTimeout(soon);
    soon = setTimeout(arrange, 50);
  });
  watch.observe(results, { childList: true, subtree: true });
  soon = setTimeout(arrange, 50);
})();
