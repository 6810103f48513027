"""The parts of the page: a click on a tab shows its part at once, in the browser; the server is only told."""

from __future__ import annotations

import json
from typing import Any

from nicegui import ui

ADDRESS = """<script>(() => {  // the part that is shown, and the run, stand in the address: back and reload find them
  let run = "";
  const [part, name] = [0, 1].map((k) => () => location.hash.slice(1).split("/")[k] || "");
  const tab = (one) => document.querySelector(`.q-tab[data-at="tab ${CSS.escape(one || "describe")}"]`);
  window.shownPart = (one) => {
    if (one !== (part() || "describe")) history.pushState(null, "", `#${one}${one === "run" && run ? `/${run}` : ""}`);
  };
  window.shownRun = (one) => {
    run = one;
    if (part() === "run") history.replaceState(null, "", `#run/${run}`);
  };
  function go() {
    if (!window.did_handshake || !tab()) return false;
    if (tab(part())?.getAttribute("aria-selected") === "false") tab(part()).click();
    if (name() && name() !== run) emitEvent("run_asked", name());
    return true;
  }
  window.addEventListener("popstate", go);
  const begin = () => part() && (go() || setTimeout(begin, 50));
  window.addEventListener("load", begin);
})();</script>"""

FIT = (  # texts of several lines that were made while another part was shown find their height now, as after an animation
    "document.querySelectorAll('.q-textarea--autogrow textarea').forEach("
    "(one) => one.dispatchEvent(new Event('animationend')))"
)


class Tabs(ui.tabs):
    """Tabs that do not wait for the server; ``panels`` are what they show."""

    LOOPBACK = False

    def __init__(self) -> None:
        super().__init__()
        self.panels: Any = None

    def show_in(self, panels: ui.tab_panels) -> None:
        """Let a click change ``panels``, which were made without tabs."""
        self.panels = panels
        ui.add_head_html(ADDRESS)
        self.set_value(panels.value)
        self.on(
            "update:model-value",
            js_handler=f"(name) => {{ [{self.id}, {panels.id}].forEach("
            "(id) => { mounted_app.elements[id].props['model-value'] = name; }); "
            f"Vue.nextTick(() => {FIT}); shownPart(name); }}",
        )

    def go(self, name: str) -> None:
        """Show a part for a reason of the server's."""
        self.panels.props["model-value"] = name
        self.panels.update()  # the server does not know what the browser shows
        self.set_value(name)
        ui.run_javascript(f"shownPart({json.dumps(name)})")
