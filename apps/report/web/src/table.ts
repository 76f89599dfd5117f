// SPDX-License-Identifier: BSD-3-Clause
import type { Table } from './data'
import { el, fixed, written } from './dom'

/** A table; `chosen` marks the row of a run, `choose` is called when a row of words is clicked. */
export function table_view(table: Table): HTMLElement {
  const numeric = table.columns.map((_, c) => table.rows.some((row) => typeof row[c] === 'number'))
  const largest = table.columns.map((_, c) =>
    Math.max(...table.rows.map((row) => (typeof row[c] === 'number' ? Math.abs(row[c]) : 0))))
  const head = el('tr', {}, ...table.columns.map((column, c) =>
    el('th', { scope: 'col', class: numeric[c] ? 'number' : '', title: column.about || undefined },
      column.name, column.unit ? el('span', { class: 'unit' }, written(column.unit)) : null)))
  const body = table.rows.map((row) => el('tr', {}, ...row.map((cell, c) => {
    const column = table.columns[c]
    const text = typeof cell === 'number' ? fixed(cell, column.digits) : cell ?? '–'
    if (c === 0 && typeof cell === 'string') return el('th', { scope: 'row' }, text)
    const data = el('td', { class: numeric[c] ? 'number' : '' }, el('span', {}, text))
    if (column.bars && typeof cell === 'number' && largest[c] > 0) {
      data.classList.add('barred')
      data.style.setProperty('--share', `${(100 * Math.abs(cell)) / largest[c]}%`)
    }
    return data
  })))
  const view = el('table', {}, table.caption ? el('caption', {}, table.caption) : null,
    el('thead', {}, head), el('tbody', {}, ...body))
  return el('div', { class: 'table-frame', tabindex: 0, role: 'region',
    'aria-label': table.caption || 'table' }, view)
}
