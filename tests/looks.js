// How the text of a page looks, so that what has been seen before need not be looked at again.
//
//   looks.all(theme)    give the page a theme, and list the different looks of its text
//   looks.pick(looks)   find an element for each of these looks
//   looks.remember()    note what is shown now
//   looks.pickNew()     find what is shown now and was not then, and say how many such parts there are
//   looks.picked        the elements that pick or pickNew found
"use strict";
window.looks = (() => {
  const PROPERTIES = [
    "display", "visibility", "opacity", "position", "float", "clip", "filter", "mixBlendMode", "zIndex",
    "color", "backgroundColor", "backgroundImage", "textShadow", "textDecorationLine", "fontSize", "fontWeight",
    "borderBottomWidth", "borderBottomColor",
  ];
  let found = new Map();
  let known = new Set();

  // An element's look is its own style and the looks of all that it lies in, as two numbers.
  function hash(text, [a, b]) {
    for (let n = 0; n < text.length; n += 1) {
      const code = text.charCodeAt(n);
      a = (Math.imul(a, 31) + code) | 0;
      b = (Math.imul(b ^ code, 16777619) + 1) | 0;
    }
    return [a, b];
  }

  const hasText = (element) => element.placeholder || element.value
    || [...element.childNodes].some((node) => node.nodeType === Node.TEXT_NODE && node.data.trim());

  function visit(element, around) {
    const style = getComputedStyle(element);
    if (style.display === "none") return;
    const look = hash([element.localName, ...PROPERTIES.map((name) => style[name])].join("|"), around);
    const name = look.join(" ");
    if (!found.has(name) && hasText(element)) found.set(name, element);
    for (const child of element.children) visit(child, look);
  }

  const shown = () => [...document.querySelectorAll("*")].filter((element) =>
    element.checkVisibility({ visibilityProperty: true }));

  const api = {
    picked: [],
    all(theme) {
      document.documentElement.dataset.theme = theme;
      found = new Map();
      visit(document.documentElement, [7, 7]);
      return [...found.keys()];
    },
    pick(looks) {
      api.picked = looks.map((name) => found.get(name));
    },
    remember() {
      known = new Set(shown());
    },
    pickNew() {
      const fresh = new Set(shown().filter((element) => !known.has(element)));
      api.picked = [...fresh].filter((element) => !fresh.has(element.parentElement));
      return api.picked.length;
    },
  };
  return api;
})();
