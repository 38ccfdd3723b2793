// The switches.

function draw() {
  const over = state.layout === "over" && !single();
  $("stage").className = single() ? "single" : state.layout;
  $("pictures").classList.toggle("over-shown", over);
  $("b").hidden = single();
  fitScales();
  shownPanes().forEach(pane => { paint(pane); drawLegend(pane); });
  const keys = shownPanes().map(scaleKey), two = over && keys[1] !== null && keys[1] !== keys[0];
  $("b").classList.toggle("own", two);
  $("pictures").classList.toggle("scaled", over && keys.some(key => key !== null));
  $("pictures").classList.toggle("two", two && keys[0] !== null);
  $("wipe").querySelector(".from").textContent = panes[0].label.textContent;
  $("wipe").querySelector(".to").textContent = panes[1].label.textContent;
  const key = topKey();
  $("scaling").disabled = key === null;
  if (key !== null) $("top").value = figure(state.tops[key]);
  $("palette").hidden = shownPanes().every(pane => ["difference", null].includes(scaleKey(pane)));
  document.querySelectorAll("#tiles button").forEach(tile =>
    tile.setAttribute("aria-pressed", String(shownRooms().some(room => room.index === Number(tile.dataset.room)))));
  for (const side of ["left", "right"]) { $(side).value = state[side]; $(`${side}Bands`).value = state[`${side}Bands`]; }
  drawMarks();
  drawMeters();
  readOut();
  colourSpace();
}

function start() {
  for (const side of ["left", "right"]) {
    $(side).append(...rooms.map(room => element("option", {value: room.index, textContent: room.title})));
    $(side).addEventListener("change", () => { state[side] = Number($(side).value); draw(); });
    $(`${side}Bands`).addEventListener("change", () => { state[`${side}Bands`] = $(`${side}Bands`).value; draw(); });
  }
  document.querySelectorAll("#tiles button").forEach(tile => tile.addEventListener("click", () => {
    state.left = state.right = Number(tile.dataset.room);
    draw();
  }));
  if (!rooms.some(room => room.view)) $("pictures").hidden = $("readout").hidden = $("controls").hidden = true;
  for (const name of ["layout", "light", "mode", "quantity"]) {
    document.querySelectorAll(`[name=${name}]`).forEach(input => {
      input.checked = input.value === state[name];
      input.addEventListener("change", () => { state[name] = input.value; draw(); });
    });
  }
  for (const name of ["scale", "palette"]) {
    $(name).value = state[name];
    $(name).addEventListener("change", () => { state[name] = $(name).value; draw(); });
  }
  $("top").addEventListener("change", () => {
    const value = Number($("top").value), key = topKey();
    if (value > 0 && Number.isFinite(value)) { state.tops[key] = value; state.byHand[key] = true; }
    draw();
  });
  $("fit").addEventListener("click", () => { state.byHand[topKey()] = false; draw(); });
  $("controls").addEventListener("submit", event => event.preventDefault());
  $("wipe").querySelector("input").addEventListener("input", event =>
    $("stage").style.setProperty("--wipe", `${event.target.value}%`));
  $("theme").addEventListener("click", () => theme(document.documentElement.dataset.theme !== "dark"));
  theme(matchMedia("(prefers-color-scheme: dark)").matches);
  $("project").addEventListener("click", () => projecting(!document.documentElement.classList.contains("projecting")));
  document.addEventListener("keydown", event => { if (event.key === "Escape") projecting(false); });
  window.addEventListener("beforeprint", () => { $("table").open = $("how").open = true; });
  $("space").addEventListener("toggle", () => { if ($("space").open) colourSpace(); });
  document.querySelectorAll("[data-file]").forEach(button => button.addEventListener("click", () => {
    const [room, file] = button.dataset.file.split(",").map(Number), {name, text, base64} = rooms[room].files[file];
    const content = text ?? Uint8Array.from(atob(base64), c => c.charCodeAt(0));
    save(name.split("/").pop(), content, "application/octet-stream");
  }));
  draw();
}

// Large type and no controls; Escape, or the button again, ends it.
function projecting(on) {
  document.documentElement.classList.toggle("projecting", on);
  $("project").textContent = on ? "Esc" : "Project";
}

function theme(dark) {
  document.documentElement.dataset.theme = dark ? "dark" : "light";
  $("theme").textContent = dark ? "Light" : "Dark";
}

start();
document.documentElement.dataset.ready = "yes";
