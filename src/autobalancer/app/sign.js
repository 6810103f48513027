// A sign while the server has not taken what was pressed or typed, so that nothing is lost in silence.
(() => {
  const PATIENCE = 300; // ms
  const KEPT = "autobalancer-lost";
  const WORDS = {
    gone: "The page had just changed under this; please do it again.",
    lost: "The connection was interrupted; what you did last may not have been taken.",
  };
  const page = () => (typeof mounted_app === "undefined" ? undefined : mounted_app); // NiceGUI's, which is no part of window
  const open = new Set(); // what the server has not confirmed
  const say = (words) => window.Quasar?.Notify.create({ message: words, type: "warning", position: "top" });

  function show() {
    const now = performance.now();
    const late = [...open].some((one) => now - one.since >= PATIENCE) || (!window.did_handshake && now - begun >= PATIENCE);
    document.body?.classList.toggle("waits", late);
  }

  // What of an element was pressed or written; other events, such as a list that shuts, may come late without harm.
  function meant({ id, listener_id }) {
    const heard = page()?.elements[id]?.events.find((one) => one.listener_id === listener_id);
    return ["click", "update:modelValue", "update:value"].includes(heard?.type);
  }

  function watched(socket) {
    const emit = socket.emit;
    socket.emit = (name, ...rest) => {
      if (name !== "event") return emit.call(socket, name, ...rest);
      const one = { since: performance.now(), meant: meant(rest[0]) };
      open.add(one);
      setTimeout(show, PATIENCE + 20);
      return emit.call(socket, name, ...rest, (answer) => {
        open.delete(one);
        if (answer === "gone" && one.meant) say(WORDS.gone);
        show();
      });
    };
    socket.on("update", (told) => {
      const field = document.activeElement;
      const box = page()?.$refs[`r${field?.id?.slice(1)}`];
      if (told[field?.id?.slice(1)] === null && typeof box?.inputValue === "string" && box.inputValue !== field.value) {
        say(WORDS.gone); // what was written into it has not been sent yet
      }
    });
    socket.on("disconnect", () => {
      if (!open.size) return;
      open.clear(); // their answers will not come
      say(WORDS.lost);
    });
  }

  const begun = performance.now();
  let socket;
  Object.defineProperty(window, "socket", {
    get: () => socket,
    set: (value) => {
      socket = value;
      watched(value);
    },
  });
  setInterval(show, PATIENCE);
  window.addEventListener("pagehide", () => open.size && sessionStorage.setItem(KEPT, "yes"));
  window.addEventListener("load", () => {
    if (sessionStorage.getItem(KEPT)) setTimeout(() => say(WORDS.lost), 500);
    sessionStorage.removeItem(KEPT);
  });
})();
