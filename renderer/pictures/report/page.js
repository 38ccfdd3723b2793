// The switches.

function draw() {
  const single = rooms.length === 1 || state.left === state.right;
  const over = state.layout === "over" && !single;
  $("stage").className = single ? "single" : state.layout;
  $("pictures").classList.toggle("over-shown", over);
  $("b").hidden = single;
  panes.slice(0, single ? 1 : 2).forEach(paint);
  $("top").value = figure(state.top);
  document.querySelectorAll("[name=mode]").forEach(input => { input.disabled = state.bands === "difference"; });
  $("palette").disabled = state.bands === "difference";
  drawLegend();
  drawMarks();
  readOut();
  colourSpace();
}

function start() {
  for (const [id, side] of [["left", "left"], ["right", "right"]]) {
    $(id).append(...rooms.map(room => element("option", {value: room.index, textContent: room.title})));
    $(id).value = state[side];
    $(id).addEventListener("change", () => { state[side] = Number($(id).value); draw(); });
  }
  $("which").hidden = $("layout").hidden = rooms.length === 1;
  if (!rooms.some(room => room.view)) state.tops.luminance = fitted();
  if (!rooms.some(room => room.view)) $("pictures").querySelectorAll("#stage, #readout").forEach(part => { part.hidden = true; });
  for (const name of ["layout", "light", "bands", "mode", "quantity"]) {
    document.querySelectorAll(`[name=${name}]`).forEach(input => {
      input.checked = input.value === state[name];
      input.addEventListener("change", () => {
        state[name] = input.value;
        if (state.top === null) state.tops.difference = fitted();
        if (["bands", "quantity"].includes(name)) base = null;
        $("slide").value = 0;
        draw();
      });
    });
  }
  for (const name of ["scale", "palette"]) {
    $(name).value = state[name];
    $(name).addEventListener("change", () => { state[name] = $(name).value; draw(); });
  }
  let base = null;
  const setTop = value => { if (value > 0 && Number.isFinite(value)) state.tops[topKey()] = value; draw(); };
  $("top").addEventListener("change", () => { base = null; $("slide").value = 0; setTop(Number($("top").value)); });
  $("slide").addEventListener("input", () => {
    base ??= state.top;
    setTop(base * 10 ** (Number($("slide").value) / 100));
  });
  $("fit").addEventListener("click", () => { base = null; $("slide").value = 0; setTop(fitted()); });
  $("controls").addEventListener("submit", event => event.preventDefault());
  $("wipe").querySelector("input").addEventListener("input", event =>
    $("stage").style.setProperty("--wipe", `${event.target.value}%`));
  $("theme").addEventListener("click", () => theme(document.documentElement.dataset.theme !== "dark"));
  theme(matchMedia("(prefers-color-scheme: dark)").matches);
  document.querySelectorAll("[data-file]").forEach(button => button.addEventListener("click", () => {
    const [room, file] = button.dataset.file.split(",").map(Number), {name, text, base64} = rooms[room].files[file];
    const content = text ?? Uint8Array.from(atob(base64), c => c.charCodeAt(0));
    save(name.split("/").pop(), content, "application/octet-stream");
  }));
  draw();
}

function theme(dark) {
  document.documentElement.dataset.theme = dark ? "dark" : "light";
  $("theme").textContent = dark ? "Light" : "Dark";
}

start();
document.documentElement.dataset.ready = "yes";
