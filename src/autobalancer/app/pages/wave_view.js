// Waveforms of measured signals as an element of the page; they are fetched once, as binary.
import { createWaves } from "autobalancer-view/waves.js";
import { unpack } from "autobalancer-view/unpack.js";
import { DARK, LIGHT } from "autobalancer-view/view.js";

export default {
  template: `<div>
    <div class="wave-tools" v-show="source">
      <button type="button" aria-label="zoom in" @click="waves?.zoom(0.5)">+</button>
      <button type="button" aria-label="zoom out" @click="waves?.zoom(2)">−</button>
      <button type="button" aria-label="show all" @click="waves?.whole()">all</button>
      <span class="quiet">drag: read values; wheel: zoom; shift and drag: move</span>
    </div>
    <div ref="waves" class="waves"></div>
  </div>`,
  props: { source: String },
  mounted() {
    this.watcher = new ResizeObserver(() => this.waves?.draw());
    this.watcher.observe(this.$el);
    this.shades = new MutationObserver(() => this.waves?.draw());
    this.shades.observe(document.body, { attributeFilter: ["class"] });
    this.load();
  },
  beforeUnmount() {
    this.watcher.disconnect();
    this.shades.disconnect();
  },
  watch: {
    source() {
      this.load();
    },
  },
  methods: {
    async load() {
      const wanted = this.source;
      this.$refs.waves.innerHTML = "";
      this.waves = null;
      this.$el.dataset.ready = "";
      if (!wanted) return;
      const answer = await fetch(wanted);
      if (wanted !== this.source) return;
      if (!answer.ok) {
        this.$refs.waves.textContent = await answer.text();
        return;
      }
      const run = unpack(await answer.arrayBuffer());
      if (wanted !== this.source) return;
      const colors = () => (document.body.classList.contains("body--dark") ? DARK : LIGHT);
      this.waves = createWaves(this.$refs.waves, run, colors, (t) => this.waves.show(t));
      this.waves.draw();
      this.$el.dataset.ready = "yes";
    },
  },
};
