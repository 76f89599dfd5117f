// SPDX-License-Identifier: BSD-3-Clause
// The parts of the page that do not move: notes, sections, pictures, the case, the foot.
import type { Note, Picture, Report, Section } from './data'
import { el } from './dom'
import { table_view } from './table'
import { xy_chart } from './xy_chart'

const kind_words: Record<Note['kind'], string> = {
  assumption: 'Assumption', warning: 'Warning', information: 'Note' }

export function notes_view(notes: Note[]): HTMLElement {
  const order: Note['kind'][] = ['warning', 'assumption', 'information']
  const sorted = [...notes].sort((a, b) => order.indexOf(a.kind) - order.indexOf(b.kind))
  return el('section', { class: 'card notes', 'aria-labelledby': 'notes-heading' },
    el('h2', { id: 'notes-heading' }, 'What these numbers rest on'),
    sorted.length ? el('ul', {}, ...sorted.map((note) => el('li', { class: note.kind },
      el('span', { class: 'kind' }, kind_words[note.kind]),
      el('span', { class: 'text' }, note.text,
        note.provenance ? el('span', { class: 'badge' }, note.provenance) : null,
        note.source ? el('span', { class: 'source' }, note.source) : null)))) : null,
    el('p', { class: 'disclaimer' }, 'For research and engineering use only. osteomill is not a medical ' +
      'device, and nothing here is medical advice. Check every number against a measurement of your own before ' +
      'it moves a machine.'))
}

export function picture_view(picture: Picture): HTMLElement {
  return el('figure', { class: 'picture' },
    el('img', { src: picture.src, alt: picture.caption, loading: 'lazy' }),
    el('figcaption', {}, picture.caption))
}

/** Charts and pictures that follow each other share a row where there is room. */
function beside_each_other(blocks: Section['blocks']): Section['blocks'][] {
  const groups: Section['blocks'][] = []
  for (const block of blocks) {
    const kind = groups.at(-1)?.[0].kind
    if (block.kind === kind && (kind === 'chart' || kind === 'picture')) groups.at(-1)!.push(block)
    else groups.push([block])
  }
  return groups
}

export function section_view(section: Section, redraws: (() => void)[]): HTMLElement {
  return el('section', { class: 'card' }, el('h2', {}, section.heading),
    ...beside_each_other(section.blocks).map((blocks) => {
      const views = blocks.map((block) => {
        if (block.kind === 'paragraph') return el('p', {}, block.text)
        if (block.kind === 'table') return table_view(block.table)
        if (block.kind === 'picture') return picture_view(block.picture)
        const chart = xy_chart(block.chart)
        redraws.push(chart.redraw)
        return chart.element
      })
      return views.length > 1 ? el('div', { class: 'side-by-side' }, ...views) : views[0]
    }))
}

async function copy(text: string, area: HTMLElement) {
  try {
    await navigator.clipboard.writeText(text)
  } catch {  // a page from disk may be denied the clipboard: select the text and copy that
    const range = document.createRange()
    range.selectNodeContents(area)
    getSelection()!.removeAllRanges()
    getSelection()!.addRange(range)
    document.execCommand('copy')
  }
}

export function case_view(text: string): HTMLElement {
  const code = el('code', {}, text)
  const button = el('button', { type: 'button', class: 'quiet' }, 'Copy')
  button.addEventListener('click', async () => {
    await copy(text, code)
    button.textContent = 'Copied'
    setTimeout(() => { button.textContent = 'Copy' }, 2000)
  })
  return el('details', { class: 'card case' },
    el('summary', {}, el('h2', {}, 'The case, as it was computed')),
    el('div', { class: 'tools' }, el('span', { class: 'hint' },
      'Every key with its value, catalogue entries and defaults included. Saved as a file, it runs again to the same result.'),
    button), el('pre', { tabindex: 0 }, code))
}

export function foot(report: Report): HTMLElement {
  const licences = document.getElementById('licences')?.textContent ?? ''
  return el('footer', {},
    el('p', {}, [report.program, report.created, 'research use only, no medical device'].filter(Boolean).join(' · ')),
    el('details', {}, el('summary', {}, 'Software within this page and its licences'),
      el('pre', { tabindex: 0 }, licences.trim())))
}
