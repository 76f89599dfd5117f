// SPDX-License-Identifier: BSD-3-Clause
// What the C++ writer (src/osteomill/io/report.cpp) puts into the page, and how it is read.

interface Packed {
  type: 'f32' | 'u32' | 'steps'
  count: number
  data: string
  low?: number
  high?: number
}

export interface Column { name: string; unit: string; digits: number; bars: boolean; about: string }
export type Cell = number | string | null
export interface Table { caption: string; columns: Column[]; rows: Cell[][] }
export interface Axis { label: string; unit: string; logarithmic: boolean; categories: string[] }
export interface Limit { name: string; value: number }
export type SeriesStyle = 'line' | 'points' | 'line-and-points' | 'bars'

export interface ChartOf<A> {
  title: string
  x: Axis
  y: Axis
  series: { name: string; style: SeriesStyle; x: A; y: A }[]
  limits: Limit[]
  about: string
}
export interface Picture { caption: string; sceneView: boolean; src: string }
export type BlockOf<A> =
  | { kind: 'paragraph'; text: string }
  | { kind: 'table'; table: Table }
  | { kind: 'chart'; chart: ChartOf<A> }
  | { kind: 'picture'; picture: Picture }
export interface SectionOf<A> { heading: string; blocks: BlockOf<A>[] }

export interface Highlight { value: string; unit: string; label: string; note: string }
export interface Note {
  kind: 'assumption' | 'warning' | 'information'
  text: string
  provenance: string
  source: string
}

export interface SignalOf<A> { name: string; unit: string; panel: string; values: A; limit?: Limit }
export interface Interval { from: number; to: number; label: string }
export interface Strip { name: string; withinCharts: boolean; intervals: Interval[] }
export interface MeshOf<A> { position: A[]; corners: A; value?: A }
export interface PathOf<A> { time: A; value: A; tip: A[]; axis: A[] }
export interface RunOf<A> {
  name: string
  about: string
  time: A
  thinnedFrom: number
  signals: SignalOf<A>[]
  strips: Strip[]
  events: { time: number; label: string }[]
  path?: PathOf<A>
  before?: MeshOf<A>
  after?: MeshOf<A>
  beforeReach?: A
  afterReach?: A
}
/** The outline: radius, height above the tip, and by how much an edge lags there behind its tip. */
export interface Cutter { outline: [number, number, number][]; radius: number; flutes: number }
export interface SceneOf<A> {
  before?: MeshOf<A>
  cutter?: Cutter
  valueName: string
  valueUnit: string
  valueLimit?: number
  meshValueName: string
  meshValueUnit: string
}
export interface ReportOf<A> {
  title: string
  subtitle: string
  program: string
  created: string
  headline: string[]
  highlights: Highlight[]
  summary: Table
  notes: Note[]
  runs: RunOf<A>[]
  scene?: SceneOf<A>
  sections: SectionOf<A>[]
  pictures: Picture[]
  case: string | null
}

export type Numbers = Float32Array | Uint32Array
export type Chart = ChartOf<Numbers>
export type Section = SectionOf<Numbers>
export type Signal = SignalOf<Numbers>
export type Run = RunOf<Numbers>
export type Mesh = MeshOf<Numbers>
export type Path = PathOf<Numbers>
export type Scene = SceneOf<Numbers>
export type Report = ReportOf<Numbers>

async function inflated(base64: string): Promise<Uint8Array> {
  const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0))
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate'))
  return new Uint8Array(await new Response(stream).arrayBuffer())
}

/** The writer stores all lowest bytes first, then all second ones, and so on. */
async function numbers(packed: Packed): Promise<Numbers> {
  const planes = await inflated(packed.data)
  const n = packed.count
  if (packed.type === 'steps') {
    const span = packed.high! - packed.low!
    const result = new Float32Array(n)
    let step = 0
    for (let i = 0; i < n; ++i) {
      step = (step + planes[i] + (planes[n + i] << 8)) & 0xffff
      result[i] = step === 65535 ? NaN : packed.low! + (span * step) / 65534
    }
    return result
  }
  const bytes = new Uint8Array(4 * n)
  for (let b = 0; b < 4; ++b) for (let i = 0; i < n; ++i) bytes[4 * i + b] = planes[b * n + i]
  if (packed.type === 'f32') return new Float32Array(bytes.buffer)
  const result = new Uint32Array(bytes.buffer)
  for (let i = 1; i < n; ++i) result[i] += result[i - 1]
  return result
}

function is_packed(value: object): value is Packed {
  return 'type' in value && 'count' in value && 'data' in value
}

/** Replaces every packed array below `value`. */
async function unpack(value: unknown): Promise<unknown> {
  if (value === null || typeof value !== 'object') return value
  if (is_packed(value)) return numbers(value)
  const holder = value as Record<string, unknown>
  await Promise.all(Object.keys(holder).map(async (key) => { holder[key] = await unpack(holder[key]) }))
  return value
}

export async function read_report(): Promise<Report> {
  const text = document.getElementById('data')!.textContent ?? ''
  return (await unpack(JSON.parse(text))) as Report
}
