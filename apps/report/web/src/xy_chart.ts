// SPDX-License-Identifier: BSD-3-Clause
// A chart of any series of places (x, y): lines, loops, clouds, bars. uPlot gives the axes.
import uPlot from 'uplot'
import { current_theme, palette } from './colours'
import type { Axis, Chart } from './data'
import { el, on_resize, reading, written } from './dom'

function named(axis: Axis): string {
  return axis.unit ? `${axis.label}, ${written(axis.unit)}` : axis.label
}

function extent(arrays: ArrayLike<number>[], also: number[], positive: boolean): [number, number] {
  let low = Infinity
  let high = -Infinity
  const take = (v: number) => {
    if (!Number.isFinite(v) || (positive && v <= 0)) return
    if (v < low) low = v
    if (v > high) high = v
  }
  for (const array of arrays) for (let i = 0; i < array.length; ++i) take(array[i])
  also.forEach(take)
  if (low > high) return positive ? [1, 10] : [0, 1]
  if (low === high) return positive ? [low / 2, high * 2] : [low - 1, high + 1]
  return [low, high]
}

function widened([low, high]: [number, number], logarithmic: boolean, share: number): [number, number] {
  if (logarithmic) return [low / 1.15, high * 1.15]
  const margin = share * (high - low)
  return [low === 0 ? 0 : low - margin, high + margin]
}

export function xy_chart(chart: Chart): { element: HTMLElement; redraw: () => void } {
  const place = el('div', { class: 'plot', role: 'img', 'aria-label':
    `${chart.title || named(chart.y)}: ${named(chart.y)} over ${named(chart.x)}; ` +
    chart.series.map((s) => s.name).join(', ') })
  const legend = el('div', { class: 'legend' })
  const pointed = el('output', { class: 'pointed' })
  const element = el('figure', { class: 'chart xy' },
    el('div', { class: 'chart-head' }, chart.title ? el('h3', {}, chart.title) : null, legend, pointed),
    place, chart.about ? el('figcaption', {}, chart.about) : null)
  let plot: uPlot | null = null
  const bars = chart.series.some((s) => s.style === 'bars')
  const categories = chart.x.categories
  const x_range: [number, number] = categories.length || bars
    ? [-0.6, Math.max(categories.length, ...chart.series.map((s) => s.x.length)) - 0.4]
    : widened(extent(chart.series.map((s) => s.x), [], chart.x.logarithmic), chart.x.logarithmic, 0.02)
  const y_range = widened(extent(chart.series.map((s) => s.y),
    [...chart.limits.map((l) => l.value), ...(bars ? [0] : [])], chart.y.logarithmic),
  chart.y.logarithmic, 0.06)

  const draw = (u: uPlot) => {
    const colours = palette(current_theme())
    const { ctx, bbox } = u
    const px = devicePixelRatio
    ctx.save()
    ctx.beginPath()
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height)
    ctx.clip()
    chart.series.forEach((series, k) => {
      ctx.strokeStyle = ctx.fillStyle = colours.lines[k % colours.lines.length]
      ctx.lineWidth = 1.5 * px
      ctx.lineJoin = 'round'
      const x = (i: number) => u.valToPos(series.x[i], 'x', true)
      const y = (i: number) => u.valToPos(series.y[i], 'y', true)
      if (series.style === 'line' || series.style === 'line-and-points') {
        ctx.beginPath()
        let down = false
        for (let i = 0; i < series.x.length; ++i) {
          const gap = !Number.isFinite(series.x[i]) || !Number.isFinite(series.y[i])
          if (!gap) down ? ctx.lineTo(x(i), y(i)) : ctx.moveTo(x(i), y(i))
          down = !gap
        }
        ctx.stroke()
      }
      if (series.style === 'points' || series.style === 'line-and-points') {
        const size = series.x.length > 2000 ? 1.2 : 3
        for (let i = 0; i < series.x.length; ++i) {
          ctx.beginPath()
          ctx.arc(x(i), y(i), size * px, 0, 2 * Math.PI)
          ctx.fill()
        }
      }
      if (series.style === 'bars') {
        const groups = chart.series.filter((s) => s.style === 'bars')
        const width = (0.7 * (u.valToPos(1, 'x', true) - u.valToPos(0, 'x', true))) / groups.length
        const offset = (groups.indexOf(series) - (groups.length - 1) / 2) * width
        const zero = u.valToPos(0, 'y', true)
        for (let i = 0; i < series.x.length; ++i)
          ctx.fillRect(x(i) + offset - width / 2, y(i), width, zero - y(i))
      }
    })
    ctx.textBaseline = 'alphabetic'
    ctx.font = `${11 * px}px system-ui, sans-serif`
    ctx.textAlign = 'right'
    ctx.setLineDash([6 * px, 4 * px])
    ctx.strokeStyle = ctx.fillStyle = colours.limit
    ctx.lineWidth = 1.2 * px
    for (const limit of chart.limits) {
      const y = u.valToPos(limit.value, 'y', true)
      ctx.beginPath()
      ctx.moveTo(bbox.left, y)
      ctx.lineTo(bbox.left + bbox.width, y)
      ctx.stroke()
      ctx.fillText(`${limit.name} ${reading(limit.value)}`, bbox.left + bbox.width - 4 * px, y - 4 * px)
    }
    ctx.restore()
  }

  const redraw = () => {
    plot?.destroy()
    const colours = palette(current_theme())
    legend.replaceChildren(...chart.series.map((series, k) => {
      const swatch = el('span', { class: 'swatch' })
      swatch.style.background = colours.lines[k % colours.lines.length]
      return el('span', { class: 'key' }, swatch, series.name)
    }))
    const axis = (label: string): uPlot.Axis => ({
      label, stroke: colours.muted, font: '12px system-ui, sans-serif', labelSize: 20,
      labelFont: '12px system-ui, sans-serif', labelGap: 2, ticks: { show: false }, gap: 6,
      grid: { stroke: colours.grid, width: 1 },
      values: (_, ticks) => ticks.map((v) => (v === null ? '' : String(v).replace('-', '−'))),
    })
    plot = new uPlot({
      width: Math.max(place.clientWidth, 200),
      height: 300,
      padding: [10, 14, 0, 0],
      legend: { show: false },
      cursor: { points: { show: false }, drag: { x: false, y: false } },
      scales: {
        x: { time: false, distr: chart.x.logarithmic ? 3 : 1, range: () => x_range },
        y: { distr: chart.y.logarithmic ? 3 : 1, range: () => y_range },
      },
      axes: [{ ...axis(named(chart.x)), size: 30, ...(categories.length ? {
        splits: () => categories.map((_, i) => i), values: () => categories,
      } : {}) }, { ...axis(named(chart.y)), size: 52 }],
      series: [{}, { show: true, stroke: 'transparent', points: { show: false } }],
      hooks: {
        draw: [draw],
        setCursor: [(u) => {
          const { left, top } = u.cursor
          if (left == null || left < 0 || categories.length) pointed.textContent = ''
          else pointed.textContent = `${reading(u.posToVal(left, 'x'))} ${chart.x.unit} · ` +
            `${reading(u.posToVal(top!, 'y'))} ${chart.y.unit}`
        }],
      },
    }, [x_range, y_range], place)
  }
  on_resize(place, () => {
    if (place.clientWidth < 50) return
    if (!plot) redraw()
    else if (plot.width !== place.clientWidth) plot.setSize({ width: place.clientWidth, height: 300 })
  })
  return { element, redraw }
}
