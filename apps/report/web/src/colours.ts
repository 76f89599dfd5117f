// SPDX-License-Identifier: BSD-3-Clause
// Colours that a colour-blind reader can tell apart: Okabe and Ito for lines, viridis for values.

export type Theme = 'light' | 'dark'

export interface Palette {
  ink: string
  muted: string
  grid: string
  surface: string
  lines: string[]
  limit: string
  ghost: string
  band: string
  clear: string
}

const palettes: Record<Theme, Palette> = {
  light: {
    ink: '#1d2329', muted: '#5b6570', grid: '#e4e2dc', surface: '#ffffff',
    lines: ['#0b6aa8', '#d55e00', '#009e73', '#a8488a', '#8a6d00', '#3c9ed1'],
    limit: '#b3261e', ghost: '#a3a9af', band: 'rgba(0, 158, 115, 0.14)', clear: '#eef1f2',
  },
  dark: {
    ink: '#e8eaec', muted: '#9aa4ae', grid: '#2c343b', surface: '#171c21',
    lines: ['#58b4ea', '#f09040', '#2fc79a', '#dc93c4', '#d9bf3f', '#8fd0f4'],
    limit: '#ff7a70', ghost: '#66707a', band: 'rgba(47, 199, 154, 0.18)', clear: '#1d2429',
  },
}

export function palette(theme: Theme): Palette { return palettes[theme] }

export function current_theme(): Theme {
  const chosen = document.documentElement.dataset.theme
  if (chosen === 'light' || chosen === 'dark') return chosen
  return matchMedia('(prefers-color-scheme: dark)').matches ? 'dark' : 'light'
}

/** Red, green, blue, evenly spaced from low to high. The same as in src/osteomill/io/colour.cpp. */
export type ColourMap = [number, number, number][]

export const viridis: ColourMap = [
  [68, 1, 84], [72, 40, 120], [62, 74, 137], [49, 104, 142], [38, 130, 142], [31, 158, 137],
  [53, 183, 121], [110, 206, 88], [181, 222, 43], [253, 231, 37],
]
/** From marrow to cortical, for densities. */
export const bone: ColourMap = [[160, 101, 78], [192, 140, 102], [220, 184, 141], [238, 217, 183], [250, 243, 228]]

/** Red, green, blue of 0...1 for a share of 0...1. */
export function colour_at(map: ColourMap, share: number): [number, number, number] {
  const place = Math.min(Math.max(share, 0), 1) * (map.length - 1)
  const i = Math.min(Math.floor(place), map.length - 2)
  const mix = (k: number) => (map[i][k] + (map[i + 1][k] - map[i][k]) * (place - i)) / 255
  return [mix(0), mix(1), mix(2)]
}

export function gradient(map: ColourMap, direction: string): string {
  return `linear-gradient(${direction}, ${map.map((s) => `rgb(${s})`).join(', ')})`
}

const materials: Record<string, Record<Theme, string>> = {
  air: { light: '#e3e9ec', dark: '#2a333a' },
  'softer bone': { light: '#ecc48d', dark: '#dcb87f' },
  'harder bone': { light: '#9c6b3f', dark: '#9a683c' },
  cancellous: { light: '#ecc48d', dark: '#dcb87f' },
  cortical: { light: '#9c6b3f', dark: '#9a683c' },
}
const others = ['#56b4e9', '#009e73', '#cc79a7', '#f0e442', '#0072b2', '#d55e00']

/** The colour of each label: materials have their own, others take turns. */
export function label_colours(labels: string[], theme: Theme): Map<string, string> {
  const result = new Map<string, string>()
  let next = 0
  for (const label of labels) {
    if (result.has(label)) continue
    const material = materials[label.toLowerCase()]
    result.set(label, material ? material[theme] : others[next++ % others.length])
  }
  return result
}
