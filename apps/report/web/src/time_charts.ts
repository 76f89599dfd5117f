// SPDX-License-Identifier: BSD-3-Clause
// The charts over time of one run: a chart a panel, strips below them, one cursor for all.
import uPlot from 'uplot'
import { current_theme, label_colours, palette } from './colours'
import type { Numbers, Run, Signal, Strip } from './data'
import { el, on_resize, reading, written } from './dom'
import type { Player } from './player'

const axis_width = 58
const right_margin = 20

type Values = (number | null)[]

function with_gaps(values: Numbers): Values {
  return Array.from(values, (v) => (Number.isNaN(v) ? null : v))
}

/** The sample at or before a time. */
export function index_at(time: ArrayLike<number>, at: number): number {
  let low = 0
  let high = time.length - 1
  while (low < high) {
    const middle = (low + high + 1) >> 1
    if (time[middle] <= at) low = middle
    else high = middle - 1
  }
  return low
}

interface Panel {
  name: string
  plot: uPlot
  head: HTMLElement
  values: { signal: Signal; shown: HTMLElement }[]
  playhead: HTMLElement
}

interface StripView { strip: Strip; canvas: HTMLCanvasElement; now: HTMLElement }

export class TimeCharts {
  private panels: Panel[] = []
  private strips: StripView[] = []
  private run: Run | null = null
  private others: Run[] = []
  private zoom: { min: number; max: number } | null = null
  private zooming = false
  private readonly body = el('div', { class: 'charts-body' })
  private readonly reset = el('button', { type: 'button', class: 'quiet', hidden: true,
    onclick: () => this.set_zoom(null) }, 'Whole time')
  readonly element: HTMLElement

  constructor(private readonly player: Player, extra: HTMLElement[] = []) {
    this.element = el('section', { class: 'card charts', 'aria-label': 'Over time' },
      el('div', { class: 'card-head' }, el('h2', {}, 'Over time'),
        el('div', { class: 'tools' }, this.reset, ...extra)),
      this.body,
      el('p', { class: 'hint screen-only' },
        'Click to go to a time, drag to zoom, double-click for the whole time.'))
    player.on_change(() => this.show_time())
    on_resize(this.body, () => this.resize())
  }

  /** Draws a run, with others faintly behind it. */
  show(run: Run, others: Run[]) {
    this.run = run
    this.others = others
    this.rebuild()
  }

  rebuild() {
    const run = this.run
    if (!run) return
    for (const panel of this.panels) panel.plot.destroy()
    this.panels = []
    this.strips = []
    this.body.replaceChildren()
    const names = [...new Set(run.signals.map((s) => s.panel))]
    names.forEach((name, i) => this.add_panel(name, i === 0, i === names.length - 1))
    for (const strip of run.strips) if (!strip.withinCharts) this.add_strip(strip)
    if (run.thinnedFrom) {
      this.body.append(el('p', { class: 'hint' },
        `Drawn from ${run.thinnedFrom.toLocaleString('en')} samples: the least and the largest of ` +
        'each short interval, so no peak is missing.'))
    }
    this.set_zoom(this.zoom)
    this.show_time()
  }

  private add_panel(name: string, first: boolean, last: boolean) {
    const run = this.run!
    const theme = current_theme()
    const colours = palette(theme)
    const signals = run.signals.filter((s) => s.panel === name)
    const unit = signals[0].unit
    const values = signals.map((signal) => ({ signal, shown: el('output', {}) }))
    const title = el('h3', {}, name, unit ? el('span', { class: 'unit' }, written(unit)) : null)
    const legend = el('div', { class: 'legend' })
    values.forEach(({ signal, shown }, i) => {
      const swatch = el('span', { class: 'swatch' })
      swatch.style.background = colours.lines[i % colours.lines.length]
      const label = signals.length > 1 || signal.name !== name ? `${signal.name} ` : ''
      legend.append(el('span', { class: 'key' }, swatch, label, shown))
    })
    if (this.others.some((o) => o.signals.some((s) => s.panel === name))) {
      const swatch = el('span', { class: 'swatch' })
      swatch.style.background = colours.ghost
      legend.append(el('span', { class: 'key' }, swatch, 'other runs'))
    }
    if (first) {
      for (const strip of run.strips.filter((s) => s.withinCharts)) {
        const swatch = el('span', { class: 'swatch band' })
        swatch.style.background = colours.band
        legend.append(el('span', { class: 'key' }, swatch, strip.name))
      }
    }
    const head = el('div', { class: 'chart-head' }, title, legend)
    const place = el('div', { class: 'plot', role: 'img', 'aria-label': this.described(name, signals) })
    this.body.append(el('figure', { class: 'chart' }, head, place))

    const limits = signals.flatMap((s) => (s.limit ? [s.limit] : []))
      .filter((l, i, all) => all.findIndex((m) => m.value === l.value && m.name === l.name) === i)
    const tables: uPlot.AlignedData[] =
      [[Array.from(run.time), ...signals.map((s) => with_gaps(s.values))]]
    const series: uPlot.Series[] = [{}, ...signals.map((s, i): uPlot.Series => ({
      label: s.name, stroke: colours.lines[i % colours.lines.length], width: 1.4,
      points: { show: false },
    }))]
    for (const other of this.others) {
      const same = other.signals.filter((s) => signals.some((t) => t.name === s.name && t.panel === s.panel))
      if (same.length === 0) continue
      tables.push([Array.from(other.time), ...same.map((s) => with_gaps(s.values))])
      for (const s of same)
        series.push({ label: `${other.name} ${s.name}`, stroke: colours.ghost, width: 1, points: { show: false } })
    }
    // What is drawn later lies above: the other runs first.
    const data = tables.length > 1 ? uPlot.join(tables) : tables[0]
    const mine = signals.length
    const order = [0, ...series.keys()].slice(1).filter((k) => k > mine || k === 0)
      .concat([...signals.keys()].map((k) => k + 1))

    const playhead = el('div', { class: 'playhead' })
    const plot = new uPlot({
      width: Math.max(this.body.clientWidth, 200),
      height: (last ? 156 : 138) + (first && run.events.length ? 10 : 0),
      padding: [first && run.events.length ? 18 : 8, right_margin, 0, 0],
      legend: { show: false },
      cursor: {
        sync: { key: 'time', scales: ['x', null] },
        drag: { x: true, y: false, dist: 6 },
        y: false,
        points: { show: false },
      },
      scales: {
        x: { time: false },
        y: { range: (_, min, max) => this.y_range(min, max, limits.map((l) => l.value)) },
      },
      axes: [
        { size: last ? 26 : 8, stroke: colours.muted, font: '12px system-ui, sans-serif', gap: 6,
          grid: { stroke: colours.grid, width: 1 }, ticks: { show: false },
          values: (_, ticks) => ticks.map((v) => (last ? `${v} s` : '')) },
        { size: axis_width, stroke: colours.muted, font: '12px system-ui, sans-serif', gap: 6,
          grid: { stroke: colours.grid, width: 1 }, ticks: { show: false }, space: 26,
          values: (_, ticks) => ticks.map((v) => String(v).replace('-', '−')) },
      ],
      series: order.map((k) => series[k]),
      hooks: {
        drawClear: [(u) => this.draw_bands(u)],
        draw: [(u) => this.draw_marks(u, limits, first)],
        setCursor: [(u) => {
          if (!(u.cursor as { event?: unknown }).event) return  // moved by another chart
          const left = u.cursor.left ?? -1
          this.player.point(left < 0 ? null : u.posToVal(left, 'x'))
        }],
        setScale: [(u, key) => { if (key === 'x') this.zoomed(u) }],
        ready: [(u) => {
          u.over.append(playhead)
          u.over.addEventListener('click', (event) => {
            const box = u.over.getBoundingClientRect()
            this.player.seek(u.posToVal(event.clientX - box.left, 'x'))
          })
          u.over.addEventListener('dblclick', () => this.set_zoom(null))
          u.over.addEventListener('mouseleave', () => this.player.point(null))
        }],
      },
    }, order.map((k) => data[k]) as uPlot.AlignedData, place)
    this.panels.push({ name, plot, head, values, playhead })
  }

  private described(name: string, signals: Signal[]): string {
    const parts = signals.map((s) => {
      let low = Infinity
      let high = -Infinity
      for (const v of s.values) {
        if (v < low) low = v
        if (v > high) high = v
      }
      return `${s.name} from ${reading(low)} to ${reading(high)} ${s.unit}` +
        (s.limit ? `, ${s.limit.name} ${reading(s.limit.value)} ${s.unit}` : '')
    })
    return `${name} over time: ${parts.join('; ')}`
  }

  private y_range(min: number | null, max: number | null, limits: number[]): [number, number] {
    const low = Math.min(min ?? 0, 0, ...limits)
    const high = Math.max(max ?? 1, ...limits)
    const margin = (high - low || 1) * (limits.length ? 0.18 : 0.1)
    return [low < 0 ? low - margin : 0, high + margin]
  }

  private draw_bands(u: uPlot) {
    const colours = palette(current_theme())
    const { ctx, bbox } = u
    ctx.save()
    ctx.beginPath()
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height)
    ctx.clip()
    ctx.fillStyle = colours.band
    for (const strip of this.run!.strips) {
      if (!strip.withinCharts) continue
      for (const { from, to } of strip.intervals) {
        const left = u.valToPos(from, 'x', true)
        ctx.fillRect(left, bbox.top, Math.max(u.valToPos(to, 'x', true) - left, 1), bbox.height)
      }
    }
    ctx.restore()
  }

  private draw_marks(u: uPlot, limits: { name: string; value: number }[], first: boolean) {
    const colours = palette(current_theme())
    const { ctx, bbox } = u
    const px = devicePixelRatio
    ctx.save()
    ctx.beginPath()
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height)
    ctx.clip()
    ctx.textBaseline = 'alphabetic'
    ctx.font = `${11 * px}px system-ui, sans-serif`
    ctx.lineWidth = 1.2 * px
    ctx.setLineDash([6 * px, 4 * px])
    for (const limit of limits) {
      const y = u.valToPos(limit.value, 'y', true)
      ctx.strokeStyle = colours.limit
      ctx.fillStyle = colours.limit
      ctx.beginPath()
      ctx.moveTo(bbox.left, y)
      ctx.lineTo(bbox.left + bbox.width, y)
      ctx.stroke()
      ctx.textAlign = 'right'
      ctx.fillText(`${limit.name} ${reading(limit.value)}`, bbox.left + bbox.width - 4 * px, y - 4 * px)
    }
    ctx.setLineDash([2 * px, 3 * px])
    ctx.strokeStyle = colours.muted
    ctx.fillStyle = colours.muted
    const places = this.run!.events.map((event) => u.valToPos(event.time, 'x', true))
    for (const x of places) {
      ctx.beginPath()
      ctx.moveTo(x, bbox.top)
      ctx.lineTo(x, bbox.top + bbox.height)
      ctx.stroke()
    }
    ctx.restore()
    if (!first) return
    ctx.save()
    ctx.font = `${11 * px}px system-ui, sans-serif`
    ctx.fillStyle = colours.muted
    ctx.textBaseline = 'alphabetic'
    ctx.textAlign = 'center'
    let free = -Infinity
    this.run!.events.forEach((event, i) => {
      const half = ctx.measureText(event.label).width / 2
      const right = bbox.left + bbox.width
      if (places[i] < bbox.left - 1 || places[i] > right + 1) return
      const x = Math.min(Math.max(places[i], bbox.left + half), right - half)
      if (x - half < free) return
      ctx.fillText(event.label, x, bbox.top - 5 * px)
      free = x + half + 8 * px
    })
    ctx.restore()
  }

  private add_strip(strip: Strip) {
    const canvas = el('canvas', { role: 'img',
      'aria-label': `${strip.name} over time, ${strip.intervals.length} intervals` })
    const now = el('output', {})
    const labels = [...new Set(strip.intervals.map((i) => i.label))]
    const colours = label_colours(labels, current_theme())
    const legend = el('div', { class: 'legend' }, ...labels.slice(0, 8).map((label) => {
      const swatch = el('span', { class: 'swatch block' })
      swatch.style.background = colours.get(label)!
      return el('span', { class: 'key' }, swatch, label)
    }))
    canvas.addEventListener('pointerdown', (event) => {
      const x = this.panels[0]?.plot.scales.x
      if (x) this.player.seek(x.min! + ((x.max! - x.min!) * event.offsetX) / canvas.clientWidth)
    })
    this.body.append(el('figure', { class: 'chart strip' },
      el('div', { class: 'chart-head' }, el('h3', {}, strip.name, el('span', { class: 'unit' }, now)), legend), canvas))
    this.strips.push({ strip, canvas, now })
  }

  private draw_strips() {
    const run = this.run!
    const theme = current_theme()
    const x = this.panels[0]?.plot.scales.x ?? { min: run.time[0], max: run.time[run.time.length - 1] }
    const [min, max] = [x.min ?? this.player.start, x.max ?? this.player.end]
    for (const { strip, canvas } of this.strips) {
      const width = Math.max(this.body.clientWidth - axis_width - right_margin, 10)
      const height = 18
      canvas.style.width = `${width}px`
      canvas.style.height = `${height}px`
      canvas.style.marginLeft = `${axis_width}px`
      canvas.width = Math.round(width * devicePixelRatio)
      canvas.height = Math.round(height * devicePixelRatio)
      const colours = label_colours(strip.intervals.map((i) => i.label), theme)
      const context = canvas.getContext('2d')!
      context.fillStyle = palette(theme).clear
      context.fillRect(0, 0, canvas.width, canvas.height)
      const place = (t: number) => ((t - min) / (max - min)) * canvas.width
      for (const { from, to, label } of strip.intervals) {
        if (to < min || from > max) continue
        context.fillStyle = colours.get(label)!
        context.fillRect(place(from), 0, Math.max(place(to) - place(from), 0.5), canvas.height)
      }
    }
  }

  private zoomed(u: uPlot) {
    const { min, max } = u.scales.x
    if (this.zooming || min == null || max == null) return
    if (!this.panels.some((p) => p.plot === u)) return  // still being built
    const whole = min <= this.player.start && max >= this.player.end
    this.set_zoom(whole ? null : { min, max })
  }

  set_zoom(zoom: { min: number; max: number } | null) {
    this.zoom = zoom
    this.zooming = true
    const to = zoom ?? { min: this.player.start, max: this.player.end }
    for (const { plot } of this.panels) plot.setScale('x', to)
    // uPlot applies scales in a microtask; only then are they ours to read.
    queueMicrotask(() => {
      this.zooming = false
      this.draw_strips()
      this.show_time()
    })
    this.reset.hidden = zoom === null
  }

  /** For the tests of the page: the time that each chart shows. */
  ranges(): (number | undefined)[][] {
    return this.panels.map(({ plot }) => [plot.scales.x.min, plot.scales.x.max])
  }

  private show_time() {
    const run = this.run
    if (!run || run.time.length === 0) return
    const at = this.player.shown
    const index = index_at(run.time, at)
    for (const { plot, values, playhead } of this.panels) {
      for (const { signal, shown } of values) shown.textContent = reading(signal.values[index])
      const { min, max } = plot.scales.x
      const visible = min != null && this.player.time >= min && this.player.time <= max!
      playhead.hidden = !visible
      if (visible) playhead.style.transform = `translateX(${plot.valToPos(this.player.time, 'x')}px)`
    }
    for (const { strip, now } of this.strips) {
      const here = strip.intervals.find((i) => i.from <= at && at < i.to)
      now.textContent = here?.label ?? ''
    }
  }

  private resize() {
    const width = this.body.clientWidth
    if (width < 50) return
    for (const { plot } of this.panels) plot.setSize({ width, height: plot.height })
    if (this.run) this.draw_strips()
    this.show_time()
  }
}
