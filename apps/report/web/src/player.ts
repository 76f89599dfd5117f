// SPDX-License-Identifier: BSD-3-Clause
// The time that all views share: where the player stands, and what the pointer looks at.

export class Player {
  time = 0
  start = 0
  end = 1
  playing = false
  speed = 1
  /** Where the pointer is on a chart; views show it in place of the time. */
  pointed: number | null = null
  private listeners: (() => void)[] = []
  private last = 0

  get shown(): number { return this.pointed ?? this.time }

  on_change(listener: () => void) { this.listeners.push(listener) }

  changed() { for (const listener of this.listeners) listener() }

  set_range(start: number, end: number) {
    this.start = start
    this.end = Math.max(end, start + 1e-9)
    this.seek(this.time)
  }

  seek(time: number) {
    this.time = Math.min(Math.max(time, this.start), this.end)
    this.changed()
  }

  point(time: number | null) {
    if (time === this.pointed) return
    this.pointed = time
    this.changed()
  }

  toggle() { this.playing ? this.pause() : this.play() }

  play() {
    if (this.time >= this.end) this.time = this.start
    this.playing = true
    this.last = performance.now()
    requestAnimationFrame((now) => this.step(now))
    this.changed()
  }

  pause() {
    this.playing = false
    this.changed()
  }

  private step(now: number) {
    if (!this.playing) return
    // A hidden page gets no frames: a long pause counts as a short one.
    this.time += Math.min(Math.max(now - this.last, 0), 200) * 1e-3 * this.speed
    this.last = now
    if (this.time >= this.end) {
      this.time = this.end
      this.playing = false
    }
    this.changed()
    if (this.playing) requestAnimationFrame((next) => this.step(next))
  }
}
