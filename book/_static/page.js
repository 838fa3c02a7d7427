// Marks what is wider than its box, so that it can fade out at its end, and be scrolled with the keyboard; and tells
// the entries of tables, which stand below each other on a phone, the heads of their columns.
"use strict";
(() => {
  const WIDE = "main :is(pre, div.math, .output, .pst-scrollable-table-container, mjx-container)";

  function mark(box) {
    const wide = box.scrollWidth > box.clientWidth + 1 && getComputedStyle(box).overflowX === "auto";
    box.classList.toggle("scrolls", wide);
    box.classList.toggle("at-end", wide && box.scrollLeft + box.clientWidth > box.scrollWidth - 2);
    if (wide) box.tabIndex = 0;
  }

  function markAll() {
    for (const box of document.querySelectorAll(WIDE)) {
      if (!box.dataset.watched) box.addEventListener("scroll", () => mark(box), { passive: true });
      box.dataset.watched = "yes";
      mark(box);
    }
  }

  function giveHeads(table) {
    const heads = [...table.querySelectorAll("thead th")].map((head) => head.textContent.trim());
    for (const row of table.querySelectorAll("tbody tr")) {
      [...row.cells].forEach((cell, n) => { if (heads[n]) cell.dataset.head = heads[n]; });
    }
  }

  addEventListener("load", async () => {
    document.querySelectorAll("table.entries").forEach(giveHeads);
    if (window.MathJax && window.MathJax.startup) await window.MathJax.startup.promise;
    markAll();
    addEventListener("resize", markAll);
  });
})();
