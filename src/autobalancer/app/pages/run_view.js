// The view as an element of the page; the run is fetched once, as binary.
import { OrbitControls, THREE } from "nicegui-scene";
import { createView } from "autobalancer-view/view.js";

export default {
  template: "<div></div>",
  props: { source: String, dark: Boolean },
  mounted() {
    this.load();
  },
  beforeUnmount() {
    this.view?.destroy();
  },
  watch: {
    source() {
      this.load();
    },
    dark(value) {
      this.view?.shade(value);
    },
  },
  methods: {
    async load() {
      const wanted = this.source;
      this.view?.destroy();
      this.view = null;
      if (!wanted) return;
      const answer = await fetch(wanted);
      if (!answer.ok) {
        this.$el.textContent = "the run could not be read";
        return;
      }
      const buffer = await answer.arrayBuffer();
      if (wanted !== this.source) return;
      this.view = createView(this.$el, buffer, { THREE, OrbitControls }, this.dark);
      this.$emit("shown");
    },
    go(t) {
      this.view?.go(t);
    },
  },
};
