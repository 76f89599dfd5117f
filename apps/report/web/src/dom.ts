// SPDX-License-Identifier: BSD-3-Clause
// Makes elements. Text goes in as text, never as markup.

type Child = Node | string | null | undefined | false
type Attributes = Record<string, string | number | boolean | undefined | ((event: Event) => void)>

function fill(element: Element, attributes: Attributes, children: Child[]) {
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === 'function') element.addEventListener(name.slice(2), value)
    else if (value === true) element.setAttribute(name, '')
    else if (value !== undefined && value !== false) element.setAttribute(name, String(value))
  }
  element.append(...children.filter((c): c is Node | string => !!c))
}

export function el<K extends keyof HTMLElementTagNameMap>(
  tag: K, attributes: Attributes = {}, ...children: Child[]): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag)
  fill(element, attributes, children)
  return element
}

/** An icon of strokes on a 16 by 16 field. */
export function icon(path: string): SVGElement {
  const space = 'http://www.w3.org/2000/svg'
  const svg = document.createElementNS(space, 'svg')
  fill(svg, { viewBox: '0 0 16 16', 'aria-hidden': 'true', class: 'icon' }, [])
  const line = document.createElementNS(space, 'path')
  line.setAttribute('d', path)
  svg.append(line)
  return svg
}

export function fixed(value: number, digits: number): string {
  if (!Number.isFinite(value)) return '–'
  const text = Math.abs(value).toFixed(digits)
  const [whole, part] = text.split('.')
  // Thin spaces between thousands from five digits on, a true minus sign.
  const grouped = whole.length > 4 ? whole.replace(/\B(?=(\d{3})+$)/g, '\u202f') : whole
  const sign = value < 0 && Number(text) !== 0 ? '−' : ''
  return sign + grouped + (part ? `.${part}` : '')
}

/** "N/mm2" as people write it. */
export function written(unit: string): string {
  return unit.replace(/m2\b/g, 'm²').replace(/m3\b/g, 'm³')
}

/** About three significant digits, for readings. */
export function reading(value: number | null | undefined): string {
  if (value === null || value === undefined || !Number.isFinite(value)) return '–'
  const size = Math.abs(value)
  if (size === 0) return '0'
  if (size >= 1e6 || size < 1e-3) return value.toExponential(2).replace('-', '−')
  return fixed(value, size >= 100 ? 0 : size >= 10 ? 1 : size >= 1 ? 2 : 3)
}

/** Calls back after the element got another size, a frame later, so that drawing may change sizes. */
export function on_resize(element: Element, act: () => void) {
  let waiting = false
  new ResizeObserver(() => {
    if (waiting) return
    waiting = true
    requestAnimationFrame(() => {
      waiting = false
      act()
    })
  }).observe(element)
}
