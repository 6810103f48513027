// A point that is moved over the picture of a stability map below it, by mouse, touch and keyboard. Places are shares of the axes, from the
// left and from below; what they mean is the server's business.
const SOON = 60; // ms between two messages while the point moves
const NEAR = 24; // how far from the point a finger may be, in units of the picture

export default {
  template: `<svg ref="over" class="over" :viewBox="'0 0 ' + size[0] + ' ' + size[1]" @pointerdown="press" @pointermove="drag"
         @pointerup="drop" @pointercancel="drop" role="group" aria-label="point of the map">
      <rect class="area" :x="area[0]" :y="area[1]" :width="area[2]" :height="area[3]" />
      <g v-if="machine" class="own" :transform="at(machine)"><circle r="6" /></g>
      <g v-if="place">
        <path class="cross" :d="cross" />
        <g class="point" ref="point" :class="look" :transform="at(place)" tabindex="0" role="slider" aria-valuemin="0"
           aria-valuemax="100" :aria-label="label" :aria-valuenow="Math.round(100 * place[0])" :aria-valuetext="words"
           aria-roledescription="point of the map" data-at="point" @keydown="step" @keyup="rest" @blur="rest">
          <circle class="grip" r="22" /><circle class="dot" r="7" />
        </g>
      </g>
    </svg>`,
  props: {
    size: Array,
    area: Array,
    point: Array,
    answer: Number,
    machine: Array,
    words: String,
    look: String,
    label: String,
  },
  data() {
    return { place: this.point, told: 0 };
  },
  watch: {
    point(there) {
      const late = this.answer && this.answer < this.told; // it was moved on meanwhile
      if (!this.held && !this.stepped && !late) this.place = there;
    },
  },
  computed: {
    cross() {
      const [x, y] = this.xy(this.place);
      const [left, top, width, height] = this.area;
      return `M${left},${y}H${left + width}M${x},${top}V${top + height}`;
    },
  },
  methods: {
    xy(place) {
      const [left, top, width, height] = this.area;
      return [left + place[0] * width, top + (1 - place[1]) * height];
    },
    at(place) {
      const [x, y] = this.xy(place);
      return `translate(${x},${y})`;
    },
    under(event) {
      const there = new DOMPoint(event.clientX, event.clientY).matrixTransform(this.$refs.over.getScreenCTM().inverse());
      const [left, top, width, height] = this.area;
      return [(there.x - left) / width, 1 - (there.y - top) / height, there];
    },
    press(event) {
      if (event.button > 0) return;
      const [x, y, there] = this.under(event);
      const slack = NEAR / Math.min(this.area[2], this.area[3]);
      if (x < -slack || x > 1 + slack || y < -slack || y > 1 + slack) return;
      const [px, py] = this.xy(this.place);
      if (event.pointerType === "touch" && Math.hypot(there.x - px, there.y - py) > NEAR) {
        this.tapped = [x, y]; // a finger that begins elsewhere scrolls the page, or taps
        return;
      }
      this.held = event.pointerId;
      this.$refs.over.setPointerCapture(event.pointerId);
      this.$refs.point?.focus();
      this.move(x, y);
      event.preventDefault();
    },
    drag(event) {
      if (this.held !== event.pointerId) return;
      const [x, y] = this.under(event);
      this.move(x, y);
    },
    drop(event) {
      if (this.held === event.pointerId) {
        this.held = null;
        this.tell(true);
      } else if (this.tapped && event.type === "pointerup") {
        this.move(...this.tapped);
        this.tell(true);
      }
      this.tapped = null;
    },
    step(event) {
      const size = event.shiftKey ? 0.05 : event.altKey ? 0.001 : 0.01;
      const way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowDown: [0, -1], ArrowUp: [0, 1] }[event.key];
      if (!way) return;
      event.preventDefault();
      this.stepped = true;
      this.move(this.place[0] + size * way[0], this.place[1] + size * way[1]);
    },
    rest() {
      if (!this.stepped) return;
      this.stepped = false;
      this.tell(true);
    },
    move(x, y) {
      this.place = [x, y].map((share) => Math.min(Math.max(share, 0), 1));
      if (!this.waiting) this.waiting = setTimeout(() => this.tell(false), SOON);
    },
    tell(last) {
      clearTimeout(this.waiting);
      this.waiting = null;
      this.told += 1;
      this.$emit("moved", { x: this.place[0], y: this.place[1], last: last, number: this.told });
    },
  },
};
