// The view as an element of the page; the run is fetched once, as binary.
import { createView } from "autobalancer-view/view.js";

const three = () => import("nicegui-scene"); // large, and not needed before there is a run

export default {
  template: "<div></div>",
  props: { source: String },
  mounted() {
    this.shades = new MutationObserver(() => this.view?.shade(this.dark()));
    this.shades.observe(document.body, { attributeFilter: ["class"] });
    this.load();
    three();
  },
  beforeUnmount() {
    this.shades.disconnect();
    this.view?.destroy();
  },
  watch: {
    source() {
      this.load();
    },
  },
  methods: {
    dark() {
      return document.body.classList.contains("body--dark");
    },
    async load() {
      const wanted = this.source;
      const answer = wanted ? await fetch(wanted) : null;
      const buffer = answer?.ok ? await answer.arrayBuffer() : null;
      if (wanted !== this.source) return;
      this.view?.destroy();
      this.view = null;
      this.$el.textContent = wanted && !buffer ? "the run could not be read" : "";
      if (buffer) this.view = createView(this.$el, buffer, three(), this.dark());
      this.$emit("shown");
    },
    go(t) {
      this.view?.go(t);
    },
  },
};
