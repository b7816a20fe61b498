// Adds the best matching sections, each with a line of its text, below each page that Sphinx's search
// finds. The text of the sections is in a script, because a page opened from a disk cannot fetch files.
(() => {
  const query = new URLSearchParams(location.search).get("q");
  const results = document.getElementById("search-results");
  if (!query || !results) return;

  const WORD = /[\p{L}\p{N}_]+/gu;
  const WINDOW = 12; // words within which terms count as close together
  const stemmer = new Stemmer();
  const stems = new Map();
  const stem = (word) => {
    if (!stems.has(word)) stems.set(word, stemmer.stemWord(word.toLowerCase()));
    return stems.get(word);
  };
  const asked = (query.match(WORD) ?? []).map((word) => word.toLowerCase());
  const terms = new Set(asked.filter((word) => !stopwords.has(word)).map(stem));

  // Finds the part of a section that contains most of the terms close together.
  const scored = ([page, anchor, title, text]) => {
    const words = [...text.matchAll(WORD)];
    const hits = words.flatMap((word, number) => (terms.has(stem(word[0])) ? [number] : []));
    let best = { terms: 0, from: 0 };
    hits.forEach((first, place) => {
      const near = hits.slice(place).filter((number) => number < first + WINDOW);
      const found = new Set(near.map((number) => stem(words[number][0]))).size;
      if (found > best.terms) best = { terms: found, from: first };
    });
    const titled = (title.match(WORD) ?? []).filter((word) => terms.has(stem(word))).length;
    const all = new Set(hits.map((number) => stem(words[number][0]))).size;
    const from = words[Math.max(0, best.from - WINDOW / 2)];
    const to = words[Math.min(words.length - 1, best.from + 2 * WINDOW)];
    return {
      page, anchor, title,
      line: hits.length ? text.slice(from.index, to.index + to[0].length) : "",
      score: 4 * best.terms + 2 * titled + all,
    };
  };
  const found = SECTIONS.map(scored).filter((one) => one.score > 0);
  found.sort((a, b) => b.score - a.score);

  const shown = (section) => {
    const item = document.createElement("li");
    const link = item.appendChild(document.createElement("a"));
    link.href = `${section.page}#${section.anchor}`;
    link.textContent = section.title;
    const line = item.appendChild(document.createElement("p"));
    for (const part of `… ${section.line} …`.split(/([\p{L}\p{N}_]+)/u)) {
      const hit = part && terms.has(stem(part));
      line.append(hit ? Object.assign(document.createElement("mark"), { textContent: part }) : part);
    }
    return item;
  };

  const arrange = () => {
    watch.disconnect();
    const list = results.querySelector("ul.search");
    const score = (item) => Number(item.dataset.best ?? 0);
    for (const item of list?.querySelectorAll(":scope > li:not([data-best])") ?? []) {
      const page = item.querySelector("a").getAttribute("href").split("#")[0];
      const sections = found.filter((one) => one.page === page && one.line).slice(0, 3);
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
