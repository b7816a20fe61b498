
// Sorts tables, searches for students, and opens all folded sections for printing.
for (const table of document.querySelectorAll("table.sortable")) {
  const heads = [...table.tHead.rows[0].cells];
  heads.forEach((head, column) => {
    // Not a <button>, because Chromium does not repeat a heading with a button on each printed page.
    const button = document.createElement("span");
    button.setAttribute("role", "button");
    button.tabIndex = 0;
    button.append(...head.childNodes);
    head.append(button);
    button.addEventListener("keydown", (event) => {
      if (event.key !== "Enter" && event.key !== " ") return;
      event.preventDefault();
      button.click();
    });
    button.addEventListener("click", () => {
      const down = head.getAttribute("aria-sort") === "ascending";
      heads.forEach((other) => other.removeAttribute("aria-sort"));
      head.setAttribute("aria-sort", down ? "descending" : "ascending");
      const key = (row) => row.cells[column].dataset.order ?? row.cells[column].textContent.trim();
      const rows = [...table.tBodies[0].rows];
      rows.sort((a, b) => key(a).localeCompare(key(b), undefined, { numeric: true }));
      const numbers = rows.every((row) => row.cells[column].dataset.order !== undefined);
      if (numbers) rows.sort((a, b) => Number(key(a)) - Number(key(b)));
      if (down) rows.reverse();
      table.tBodies[0].append(...rows);
    });
  });
}
const search = document.getElementById("search");
search.parentElement.hidden = false;
search.addEventListener("input", () => {
  const words = search.value.toLowerCase().split(/\s+/).filter(Boolean);
  let found = 0;
  for (const entry of document.querySelectorAll("[data-student]")) {
    const text = entry.dataset.student.toLowerCase();
    entry.hidden = !words.every((word) => text.includes(word));
    found += entry.tagName === "TR" && !entry.hidden;
  }
  document.getElementById("found").textContent = words.length ? `${found} found` : "";
});
// A link to a student opens the student's folded section.
const open = () => {
  const fold = document.getElementById(decodeURIComponent(location.hash.slice(1)));
  if (fold instanceof HTMLDetailsElement) fold.open = true;
};
addEventListener("hashchange", open);
open();
let closed = [];
addEventListener("beforeprint", () => {
  closed = [...document.querySelectorAll("details:not([open])")];
  for (const fold of closed) fold.open = true;
});
addEventListener("afterprint", () => {
  for (const fold of closed) fold.open = false;
});
