// Values under the pointer, or under a mark that the arrow keys move.
(() => {
  const make = (name, more) => Object.assign(document.createElement(name), more);
  const numbers = (text) => text.split(" ").map(Number);
  const short = (value) => String(Number(value.toPrecision(3))).replace("-", "−");

  // The lines of a drawing: name, class, and value at a place on the paper.
  function series(svg) {
    const names = [...svg.closest("figure").querySelectorAll(".legend li")];
    const axis = numbers(svg.dataset.y), scale = (axis[1] - axis[0]) / (axis[3] - axis[2]);
    const between = (points, x) => {
      for (let n = 1; n < points.length; n++) {
        const [a, b] = [points[n - 1], points[n]];
        if ((a[0] - x) * (b[0] - x) > 0) continue;
        return a[0] === b[0] ? b[1] : a[1] + ((x - a[0]) / (b[0] - a[0])) * (b[1] - a[1]);
      }
      return NaN;
    };
    return [...svg.querySelectorAll("polyline")].map((shape) => {
      const kind = shape.getAttribute("class").split(" ").find((word) => /^([kt]\d|ink)$/.test(word));
      const points = shape.getAttribute("points").split(" ").map((pair) => pair.split(",").map(Number));
      const item = names.find((li) => li.firstChild.classList.contains(kind));
      const at = (x) => axis[0] + scale * (between(points, x) - axis[2]);
      return { kind, name: item ? item.textContent : "", at };
    });
  }

  for (const svg of document.querySelectorAll("svg[data-x]")) {
    const lines = series(svg);
    const [from, to, left, right] = numbers(svg.dataset.x);
    const [xTitle, yTitle] = [...svg.querySelectorAll(".title")].map((text) => text.textContent);
    const unit = (title) => (title.match(/\[(.*)\]/) || ["", ""])[1].replace(/^-$/, "");
    const frame = svg.querySelector(".frame"), mark = document.createElementNS(svg.namespaceURI, "line");
    mark.setAttribute("class", "reading");
    mark.setAttribute("y1", Number(frame.getAttribute("y")));
    mark.setAttribute("y2", Number(frame.getAttribute("y")) + Number(frame.getAttribute("height")));
    mark.style.display = "none";
    svg.append(mark);
    const values = make("p", { className: "values", hidden: true });
    values.setAttribute("aria-live", "polite");
    svg.after(values);
    let place = null;
    function read(x) {
      place = x === null ? null : Math.min(Math.max(x, left), right);
      mark.style.display = place === null ? "none" : "";
      values.hidden = place === null;
      if (place === null) return;
      mark.setAttribute("x1", place);
      mark.setAttribute("x2", place);
      const found = new Map();
      for (const { kind, name, at } of lines) {
        const value = at(place);
        if (Number.isFinite(value)) found.set(kind, { name, value });
      }
      const where = from + ((place - left) / (right - left)) * (to - from);
      values.replaceChildren(`${xTitle.replace(/ \[.*/, "")} ${short(where)} ${unit(xTitle)}: `);
      for (const [kind, { name, value }] of found) {
        const one = make("span", { className: kind });
        if (name) one.append(make("i"), `${name} `);
        one.append(make("b", { textContent: `${short(value)} ${unit(yTitle)}` }));
        values.append(one);
      }
    }
    const onPaper = (event) => {
      const box = svg.getBoundingClientRect();
      return ((event.clientX - box.left) / box.width) * svg.viewBox.baseVal.width;
    };
    svg.tabIndex = 0;
    svg.addEventListener("pointermove", (event) => read(onPaper(event)));
    svg.addEventListener("pointerdown", (event) => read(onPaper(event)));
    svg.addEventListener("pointerleave", () => { if (document.activeElement !== svg) read(null); });
    svg.addEventListener("blur", () => read(null));
    svg.addEventListener("keydown", (event) => {
      const by = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      if (event.key === "Escape") read(null);
      if (!by || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      read((place === null ? (by > 0 ? left : right) : place + (by * (right - left)) / 50));
    });
  }
})();
