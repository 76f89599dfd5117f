// SPDX-License-Identifier: BSD-3-Clause
// Puts the page together. data-ready or data-error on <html> tells how that went.
import 'uplot/dist/uPlot.min.css'
import './style.css'
import { read_report, type Report, type Run } from './data'
import { el, fixed, icon } from './dom'
import { case_view, foot, notes_view, picture_view, section_view } from './parts'
import { Player } from './player'
import { SceneView } from './scene'
import { table_view } from './table'
import { TimeCharts } from './time_charts'

const root = document.documentElement

function fail(error: unknown) {
  root.dataset.error = error instanceof Error ? `${error.message}\n${error.stack}` : String(error)
  document.getElementById('page')!.append(
    el('p', { class: 'broken', role: 'alert' }, `This report cannot be shown: ${error}`))
}
addEventListener('error', (event) => { root.dataset.error = event.message })
addEventListener('unhandledrejection', (event) => { root.dataset.error = String(event.reason) })

function theme_button(changed: () => void): HTMLElement {
  const names: Record<string, string> = { auto: 'as the system', light: 'light', dark: 'dark' }
  const next: Record<string, string> = { auto: 'light', light: 'dark', dark: 'auto' }
  const text = el('span', {})
  const button = el('button', { type: 'button', class: 'quiet' },
    icon('M8 1.5a6.5 6.5 0 1 0 0 13z M8 1.5a6.5 6.5 0 0 1 0 13'), text)
  const say = () => { text.textContent = `Colours: ${names[root.dataset.theme ?? 'auto']}` }
  button.addEventListener('click', () => {
    root.dataset.theme = next[root.dataset.theme ?? 'auto']
    say()
    changed()
  })
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', changed)
  say()
  return button
}

function header(report: Report, theme: HTMLElement): HTMLElement {
  return el('header', {},
    el('div', { class: 'brand' }, el('span', {}, el('b', {}, 'osteomill'), ' report'),
      el('div', { class: 'tools screen-only' }, theme,
        el('button', { type: 'button', class: 'quiet', onclick: () => print() },
          icon('M4 6V2h8v4 M4 12H2V6h12v6h-2 M4 10h8v4H4z'), 'Print'))),
    el('h1', {}, report.title),
    report.subtitle ? el('p', { class: 'subtitle' }, report.subtitle) : null,
    report.headline.length ? el('div', { class: 'headline' }, ...report.headline.map((s) => el('p', {}, s))) : null,
    report.highlights.length ? el('dl', { class: 'highlights' }, ...report.highlights.map((h) =>
      el('div', {}, el('dt', {}, h.label), el('dd', {}, h.value, h.unit ? el('span', { class: 'unit' }, h.unit) : null),
        h.note ? el('dd', { class: 'note' }, h.note) : null))) : null)
}

const speeds = [0.1, 0.25, 0.5, 1, 2, 5, 10, 20]

function player_bar(report: Report, player: Player, choose: (index: number) => void): HTMLElement {
  const play = el('button', { type: 'button', class: 'play', 'aria-label': 'Play' })
  play.addEventListener('click', () => player.toggle())
  const scrub = el('input', { type: 'range', class: 'scrub', 'aria-label': 'Time', step: 'any', min: 0, max: 1 })
  scrub.addEventListener('input', () => player.seek(Number(scrub.value)))
  const time = el('output', { class: 'time' })
  const speed = el('select', { 'aria-label': 'Speed' },
    ...speeds.map((s) => el('option', { value: s, selected: s === 1 }, `${s}×`)))
  speed.addEventListener('change', () => { player.speed = Number(speed.value) })
  let was_playing: boolean | null = null
  player.on_change(() => {
    scrub.min = String(player.start)
    scrub.max = String(player.end)
    scrub.value = String(player.time)
    const digits = player.end - player.start < 2 ? 3 : 1
    const text = `${fixed(player.time, digits)} s`
    scrub.setAttribute('aria-valuetext', text)
    time.textContent = `${fixed(player.time, digits)} / ${fixed(player.end, digits)} s`
    if (player.playing !== was_playing) {
      was_playing = player.playing
      play.replaceChildren(icon(player.playing ? 'M4.5 2.5h2v11h-2z M9.5 2.5h2v11h-2z' : 'M4 2.5l9 5.5-9 5.5z'))
      play.setAttribute('aria-label', player.playing ? 'Pause' : 'Play')
    }
  })
  const runs = report.runs.length > 1
    ? el('fieldset', { class: 'segments runs' }, el('legend', { class: 'sr' }, 'Run'),
      ...report.runs.map((run, i) => el('label', {}, el('input', { type: 'radio', name: 'run', value: i,
        checked: i === 0, onchange: () => choose(i) }), el('span', {}, run.name))))
    : el('span', { class: 'only-run' }, report.runs[0].name)
  return el('nav', { class: 'player', 'aria-label': 'Run and time' },
    runs, el('div', { class: 'transport screen-only' }, play, scrub, time, speed))
}

function has_scene(report: Report): boolean {
  return !!report.scene && (!!report.scene.before || report.runs.some((r) => r.before || r.after || r.path))
}

async function start() {
  const report = await read_report()
  document.title = report.title
  const page = document.getElementById('page')!
  const player = new Player()
  const redraws: (() => void)[] = []
  page.append(header(report, theme_button(() => redraws.forEach((redraw) => redraw()))))
  const main = el('main', {})
  page.append(main)
  if (report.summary.rows.length)
    main.append(el('section', { class: 'card summary' }, el('h2', {}, 'Summary'), table_view(report.summary)))

  const timed = report.runs.filter((run) => run.time.length > 0 || run.path)
  if (timed.length > 0) {
    let compared = false
    let chosen = report.runs[0]
    const compare = el('input', { type: 'checkbox' })
    const charts = new TimeCharts(player, report.runs.length > 1
      ? [el('label', { class: 'check' }, compare, 'Other runs behind')] : [])
    const scene = has_scene(report) ? new SceneView(report, player) : null
    const about = el('p', { class: 'run-about' })
    const show = (run: Run) => {
      chosen = run
      root.dataset.run = run.name
      about.textContent = run.about
      about.hidden = !run.about
      for (const row of document.querySelectorAll('.summary tbody tr'))
        row.toggleAttribute('aria-current', row.firstElementChild?.textContent === run.name)
      const ends = [run.time, run.path?.time].filter((t) => t && t.length > 0).map((t) => [t![0], t![t!.length - 1]])
      player.pause()
      player.set_range(Math.min(...ends.map((e) => e[0])), Math.max(...ends.map((e) => e[1])))
      charts.set_zoom(null)
      charts.show(run, compared ? report.runs.filter((r) => r !== run) : [])
      scene?.show(run)
    }
    compare.addEventListener('change', () => { compared = compare.checked; show(chosen) })
    const bar = player_bar(report, player, (i) => show(report.runs[i]))
    main.append(bar, about,
      el('div', { class: scene ? 'views' : 'views single' }, scene ? scene.element : null, charts.element))
    redraws.push(() => charts.rebuild(), () => scene?.recolour())
    player.time = Infinity
    show(report.runs[0])
    // The rows of the summary choose their runs as well.
    for (const row of document.querySelectorAll<HTMLElement>('.summary tbody tr')) {
      const index = report.runs.findIndex((r) => r.name === row.firstElementChild?.textContent)
      const choice = bar.querySelectorAll<HTMLInputElement>('.runs input')[index]
      if (!choice) continue
      row.classList.add('choice')
      row.addEventListener('click', () => choice.click())
    }
    addEventListener('keydown', (event) => {
      if (event.key !== ' ' || event.target !== document.body) return
      event.preventDefault()
      player.toggle()
    })
    // What the tests of the page look at.
    Object.assign(window, { osteomill: { player, drawn: () => scene?.drawn(), zoom: () => charts.ranges() } })
  }
  for (const section of report.sections) main.append(section_view(section, redraws))
  const pictures = report.pictures.filter((p) => !p.sceneView || !has_scene(report))
  if (pictures.length)
    main.append(el('section', { class: 'card' }, el('h2', {}, 'Pictures'),
      el('div', { class: 'pictures' }, ...pictures.map(picture_view))))
  main.append(notes_view(report.notes))
  if (report.case) main.append(case_view(report.case))
  page.append(foot(report))
  addEventListener('beforeprint', () => {
    for (const details of document.querySelectorAll<HTMLDetailsElement>('details.case')) details.open = false
  })
  // Two frames later everything has been laid out and drawn once.
  requestAnimationFrame(() => requestAnimationFrame(() => { root.dataset.ready = 'true' }))
}

start().catch(fail)
