// How the elements of a page look, so that what has been seen before need not be looked at again.
//
//   looks.remember(theme)  give the page a theme, and keep how everything looks
//   looks.compare(theme)   give it a theme, and find what looks otherwise than was remembered for that theme
//   looks.changed          the elements that compare found
"use strict";
window.looks = (() => {
  const PROPERTIES = [
    "display", "visibility", "opacity", "position", "float", "clip", "filter", "mixBlendMode", "zIndex",
    "color", "backgroundColor", "backgroundImage", "textShadow", "textDecorationLine", "fontSize", "fontWeight",
    "borderBottomWidth", "borderBottomColor",
  ];
  const remembered = {};

  // An element's look is its own style and the looks of all that it lies in, as one number.
  function hash(text, start) {
    let value = start;
    for (let n = 0; n < text.length; n += 1) value = (Math.imul(value, 31) + text.charCodeAt(n)) | 0;
    return value;
  }

  function seen() {
    const found = new Map();
    const visit = (element, around) => {
      const style = getComputedStyle(element);
      if (style.display === "none") return;
      const look = hash(PROPERTIES.map((name) => style[name]).join("|"), around);
      found.set(element, look);
      for (const child of element.children) visit(child, look);
    };
    visit(document.documentElement, 7);
    return found;
  }

  const api = {
    changed: [],
    remember(theme) {
      document.documentElement.dataset.theme = theme;
      remembered[theme] = seen();
    },
    compare(theme) {
      document.documentElement.dataset.theme = theme;
      const changed = [...seen()].filter(([element, look]) => remembered[theme].get(element) !== look);
      const elements = new Set(changed.map(([element]) => element));
      api.changed = [...elements].filter((element) => !elements.has(element.parentElement));
    },
  };
  return api;
})();
