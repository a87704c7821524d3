(function (root) {
  const data = JSON.parse(root.querySelector("script[type='application/json']").textContent);
  const svg = root.querySelector("svg"), paths = root.querySelectorAll("path.moves");
  const range = root.querySelector("input"), shown = root.querySelector("output");
  const note = root.querySelector(".rigsim-note"), button = root.querySelector("button");
  let playing = false;

  function show() {
    const i = Number(range.value), text = data.texts[i];
    paths.forEach((path, k) => path.setAttribute("d", data.paths[k][i]));
    shown.textContent = text;
    range.setAttribute("aria-valuetext", text);
    svg.setAttribute("aria-label", [data.alt, data.name + ": " + text + ".", data.notes[i]].join(" ").trim());
    if (note) note.textContent = data.notes[i];
  }

  function play(on) {
    playing = on;
    button.textContent = on ? "Pause" : "Play";
    if (!on) return;
    const count = data.texts.length, last = count - 1;
    const from = Number(range.value) < last ? Number(range.value) : 0;
    const once = matchMedia("(prefers-reduced-motion: reduce)").matches;
    let begun = null;
    requestAnimationFrame(function step(now) {
      if (!playing || !root.isConnected) return;
      if (begun === null) begun = now;
      const at = Math.floor(from + ((now - begun) / 1000 / data.seconds) * count);
      range.value = once ? Math.min(at, last) : at % count;
      show();
      if (once && at >= last) return play(false);
      requestAnimationFrame(step);
    });
  }

  range.addEventListener("input", () => { if (playing) play(false); show(); });
  if (button) {
    button.addEventListener("click", () => play(!playing));
    range.addEventListener("keydown", (event) => {
      if (event.key !== " ") return;
      event.preventDefault();
      play(!playing);
    });
  }
  show();
})(document.currentScript.closest(".rigsim-moving"));
