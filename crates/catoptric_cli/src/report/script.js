// The pictures zoom and move together, show the reference or the differences, and tell the values of a pixel.
(() => {
  const gallery = document.querySelector(".gallery");
  if (!gallery) return;
  const size = [Number(gallery.dataset.width), Number(gallery.dataset.height)];
  const views = [...gallery.querySelectorAll(".view")];
  const reference = gallery.querySelector(".of-reference img");
  const most = Math.max(16, Math.max(...size) / 8);
  // The left upper corner is at x, y: shares of a view, 0 or less.
  const place = { zoom: 1, x: 0, y: 0 };
  const toggle = (name) => gallery.querySelector(`.tools [data-do="${name}"]`);

  for (const under of gallery.querySelectorAll("img.under")) under.src = reference.src;
  for (const input of gallery.querySelectorAll("input[type=range]")) {
    const view = input.closest("figure").querySelector(".view");
    input.addEventListener("input", () => {
      view.style.setProperty("--at", input.value + "%");
      label();
    });
    input.value = 0;
  }

  const show = () => {
    place.zoom = Math.min(most, Math.max(1, place.zoom));
    for (const axis of ["x", "y"]) place[axis] = Math.min(0, Math.max(1 - place.zoom, place[axis]));
    gallery.style.setProperty("--zoom", place.zoom);
    gallery.style.setProperty("--x", 100 * place.x + "%");
    gallery.style.setProperty("--y", 100 * place.y + "%");
    gallery.classList.toggle("zoomed", place.zoom > 1);
    const wide = views[0].clientWidth * place.zoom * (window.devicePixelRatio || 1);
    gallery.classList.toggle("pixels", wide > 2 * size[0]);
    if (pointed) mark();
  };
  // The point of a view at shares x, y stays where it is.
  const zoom = (factor, x = 0.5, y = 0.5) => {
    const next = Math.min(most, Math.max(1, place.zoom * factor));
    place.x = x - (x - place.x) * (next / place.zoom);
    place.y = y - (y - place.y) * (next / place.zoom);
    place.zoom = next;
    show();
  };
  const move = (x, y) => {
    place.x += x;
    place.y += y;
    show();
  };
  const whole = () => {
    Object.assign(place, { zoom: 1, x: 0, y: 0 });
    show();
  };

  // Reference and differences.
  const label = () => {
    const isReference = gallery.classList.contains("show-reference");
    for (const view of views.filter((view) => !view.matches(".of-reference"))) {
      const figure = view.closest("figure");
      const isHeat = gallery.classList.contains("show-heat") || figure.classList.contains("own-heat");
      const tag = view.querySelector(".tag");
      const part = Number(figure.querySelector("input").value);
      const mixed = part > 0 ? `reference | ${tag.dataset.own}` : tag.dataset.own;
      tag.textContent = isReference ? "reference" : isHeat ? "differences (FLIP)" : mixed;
    }
  };
  const press = (button, element, name, on) => {
    element.classList.toggle(name, on);
    button.setAttribute("aria-pressed", String(element.classList.contains(name)));
    label();
  };
  const showReference = (on) => press(toggle("reference"), gallery, "show-reference", on);
  const acts = {
    in: () => zoom(1.5),
    out: () => zoom(1 / 1.5),
    whole,
    reference: () => showReference(),
    heat: () => press(toggle("heat"), gallery, "show-heat"),
    "own-heat": (button) => press(button, button.closest("figure"), "own-heat"),
  };
  gallery.addEventListener("click", (event) => {
    const button = event.target.closest("button[data-do]");
    if (button) acts[button.dataset.do](button);
  });

  // Values of a pixel, read one at a time.
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = 1;
  const context = canvas.getContext("2d", { willReadFrequently: true });
  const read = (image, [x, y]) => {
    if (!image || !image.complete || !image.naturalWidth) return null;
    context.drawImage(image, x, y, 1, 1, 0, 0, 1, 1);
    return [...context.getImageData(0, 0, 1, 1).data.slice(0, 3)];
  };
  const heat = gallery.dataset.heat.match(/.{6}/g).map((hex) => [0, 2, 4].map((at) => parseInt(hex.slice(at, at + 2), 16)));
  const flipOf = (color) => {
    const distance = (other) => other.reduce((sum, value, channel) => sum + (value - color[channel]) ** 2, 0);
    let best = 0;
    heat.forEach((other, index) => { if (distance(other) < distance(heat[best])) best = index; });
    return best / (heat.length - 1);
  };
  const swatch = (color) => {
    const box = document.createElement("span");
    box.className = "swatch";
    box.style.background = `rgb(${color.join(" ")})`;
    return box;
  };
  let pointed = null;
  const mark = () => {
    const cross = ["x", "y"].map((axis, at) => place[axis] + ((pointed[at] + 0.5) / size[at]) * place.zoom);
    gallery.style.setProperty("--cross-x", 100 * cross[0] + "%");
    gallery.style.setProperty("--cross-y", 100 * cross[1] + "%");
  };
  const point = (x, y) => {
    const share = [(x - place.x) / place.zoom, (y - place.y) / place.zoom];
    pointed = share.map((part, at) => Math.min(size[at] - 1, Math.max(0, Math.floor(part * size[at]))));
    gallery.classList.add("pointed");
    mark();
    gallery.querySelector(".at").textContent = `pixel ${pointed[0]}, ${pointed[1]} (sRGB, 0 to 255)`;
    const truth = read(reference, pointed);
    for (const view of views) {
      const output = view.closest("figure").querySelector(".value");
      const own = read(view.querySelector("img.own"), pointed);
      if (!own || !truth) continue;
      const words = [swatch(own), own.join(" ")];
      if (!view.matches(".of-reference")) {
        const map = read(view.querySelector("img.heat"), pointed);
        const off = Math.max(...own.map((value, channel) => Math.abs(value - truth[channel])));
        const error = map ? `, FLIP ${flipOf(map).toFixed(3)}` : "";
        words.push(" \u2014 reference ", swatch(truth), `${truth.join(" ")}: off by ${off}${error}`);
      }
      output.replaceChildren(...words);
    }
  };
  const middle = () => point(0.5, 0.5);

  // Pointers: one moves, two zoom.
  const shares = (view, event) => {
    const box = view.getBoundingClientRect();
    return [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
  };
  const down = new Map();
  let lastScroll = -Infinity;
  window.addEventListener("scroll", () => { lastScroll = performance.now(); }, { passive: true });
  for (const view of views) {
    view.addEventListener("dragstart", (event) => event.preventDefault());
    view.addEventListener("pointerdown", (event) => {
      down.set(event.pointerId, shares(view, event));
      if (place.zoom > 1 || down.size > 1) view.setPointerCapture(event.pointerId);
      point(...shares(view, event));
    });
    view.addEventListener("pointermove", (event) => {
      const now = shares(view, event);
      const before = down.get(event.pointerId);
      if (before) {
        if (down.size === 1) move(now[0] - before[0], now[1] - before[1]);
        if (down.size === 2) {
          const [other] = [...down].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
          const apart = (at) => Math.hypot((at[0] - other[0]) * size[0], (at[1] - other[1]) * size[1]);
          if (apart(before) > 0) zoom(apart(now) / apart(before), (now[0] + other[0]) / 2, (now[1] + other[1]) / 2);
          move((now[0] - before[0]) / 2, (now[1] - before[1]) / 2);
        }
        down.set(event.pointerId, now);
      }
      point(...now);
    });
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
      view.addEventListener(end, (event) => down.delete(event.pointerId));
    }
    view.addEventListener("pointerleave", (event) => { if (!view.hasPointerCapture(event.pointerId)) down.delete(event.pointerId); });
    view.addEventListener("wheel", (event) => {
      const isOut = event.deltaY > 0;
      // A page that is being scrolled goes on, and so does one whose pictures are whole already.
      if (!event.ctrlKey && (performance.now() - lastScroll < 300 || (isOut && place.zoom <= 1))) return;
      event.preventDefault();
      const step = event.deltaMode === 1 ? 33 * event.deltaY : event.deltaY;
      zoom(Math.exp(-Math.max(-120, Math.min(120, step)) * (event.ctrlKey ? 0.01 : 0.003)), ...shares(view, event));
      point(...shares(view, event));
    }, { passive: false });
    view.addEventListener("focus", () => { if (view.matches(":focus-visible") && !pointed) middle(); });
  }

  // Keys: of a view that has the focus, and of the page where nothing takes letters.
  const arrows = { ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
  let heldSince = null;
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.matches("input")) return;
    const view = event.target.closest && event.target.closest(".view");
    const key = event.key.toLowerCase();
    if (view && arrows[event.key] && place.zoom > 1) {
      move(0.1 * arrows[event.key][0], 0.1 * arrows[event.key][1]);
      middle();
    } else if (key === "+" || key === "=" || key === "-") {
      zoom(key === "-" ? 1 / 1.25 : 1.25);
      if (view) middle();
    } else if (key === "0") {
      whole();
    } else if (key === "h" && !event.repeat) {
      acts.heat();
    } else if (key === "r") {
      if (event.repeat) return;
      heldSince = gallery.classList.contains("show-reference") ? null : performance.now();
      showReference();
    } else {
      return;
    }
    event.preventDefault();
  });
  document.addEventListener("keyup", (event) => {
    if (event.key.toLowerCase() !== "r") return;
    // Held for a while it is let go, pressed shortly it stays.
    if (heldSince !== null && performance.now() - heldSince > 300) showReference(false);
    heldSince = null;
  });
  window.addEventListener("resize", show);
  show();
  label();
})();
