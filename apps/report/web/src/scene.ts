// SPDX-License-Identifier: BSD-3-Clause
// The 3-D view: the stock as it is being cut, the path coloured by a value, the cutter.
import * as THREE from 'three'
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js'
import { LineMaterial } from 'three/examples/jsm/lines/LineMaterial.js'
import { LineSegments2 } from 'three/examples/jsm/lines/LineSegments2.js'
import { LineSegmentsGeometry } from 'three/examples/jsm/lines/LineSegmentsGeometry.js'
import { bone, type ColourMap, current_theme, gradient, viridis } from './colours'
import type { Mesh, Numbers, Report, Run } from './data'
import { el, on_resize, reading, written } from './dom'
import type { Player } from './player'
import { axis_of, cutter_model, mapped_colour, place_mm, stock_material, swept_floor } from './scene_parts'
import { index_at } from './time_charts'

type Stage = 'before' | 'now' | 'after'

export class SceneView {
  readonly element: HTMLElement
  private readonly has_stock: boolean
  private readonly has_values: boolean
  /** Why there is no picture; empty when there is one. */
  failure = ''
  private readonly canvas = el('canvas', { tabindex: 0, role: 'img' })
  private readonly frame = el('div', { class: 'scene-frame' })
  private readonly print = el('img', { class: 'print-only', alt: '3-D view of the stock and the path' })
  private renderer!: THREE.WebGLRenderer
  private controls!: OrbitControls
  private readonly camera = new THREE.PerspectiveCamera(32, 1, 0.1, 5000)
  private readonly world = new THREE.Scene()
  private readonly triad = new THREE.Scene()
  private readonly triad_camera = new THREE.PerspectiveCamera(30, 1, 0.1, 50)
  private readonly content = new THREE.Group()
  private readonly uniforms = {
    time: { value: 0 }, cut: { value: 0 }, mapping: { value: 1 },
    tinting: { value: 0 },
    bone: { value: new THREE.Color(0xe9dfc9) }, fresh: { value: new THREE.Color(0xd98f6a) },
    inside: { value: new THREE.Color(0xb98d6b) },
  }
  private readonly after_uniforms = { ...this.uniforms, time: { value: 0 } }
  private before: THREE.Mesh | null = null
  private after: THREE.Mesh | null = null
  private line: LineSegments2 | null = null
  private trail: LineSegments2 | null = null
  private floor: ReturnType<typeof swept_floor> | null = null
  private cutter: THREE.Group | null = null
  private readonly clip = new THREE.Plane(new THREE.Vector3(-1, 0, 0), 0)
  private clip_axis = -1
  private clip_share = 0.5
  private stage: Stage = 'now'
  private opacity = 1
  private box = new THREE.Box3()
  private run: Run | null = null
  private waiting = false
  private readonly legend = el('div', { class: 'colour-bar' })
  private readonly caption = el('p', { class: 'hint' })

  constructor(private readonly report: Report, private readonly player: Player) {
    this.has_stock = !!report.scene?.before || report.runs.some((run) => run.before || run.after)
    this.has_values = !!report.scene?.meshValueName &&
      [report.scene.before, ...report.runs.map((run) => run.after)].some((mesh) => mesh?.value)
    this.uniforms.tinting.value = this.has_values ? 1 : 0
    this.frame.append(this.canvas, this.print)
    this.element = el('section', { class: 'card scene', 'aria-label': 'Stock, path and cutter in 3-D' },
      el('div', { class: 'card-head' }, el('h2', {}, this.has_stock ? 'Stock and path' : 'Path')), this.frame)
    try {
      this.renderer = new THREE.WebGLRenderer({ canvas: this.canvas, antialias: true, alpha: true,
        preserveDrawingBuffer: true })
    } catch {
      this.give_up()
      return
    }
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2))
    this.renderer.autoClear = false
    this.camera.up.set(0, 0, 1)
    this.controls = new OrbitControls(this.camera, this.canvas)
    this.controls.addEventListener('change', () => this.draw_soon())
    const head = new THREE.DirectionalLight(0xffffff, 2.1)
    head.position.set(0.5, 0.9, 1.2)
    this.camera.add(head)
    this.world.add(this.camera, new THREE.HemisphereLight(0xffffff, 0x8d8478, 1.25), this.content)
    this.triad.add(...[[1, 0, 0], [0, 1, 0], [0, 0, 1]].map((d, i) => new THREE.ArrowHelper(
      new THREE.Vector3(...d), new THREE.Vector3(), 1, [0xd55e00, 0x009e73, 0x0072b2][i], 0.3, 0.2)))
    if (report.scene?.cutter) {
      this.cutter = cutter_model(report.scene.cutter)
      this.world.add(this.cutter)
    }
    this.element.append(this.legend, this.make_tools(), this.caption)
    this.controls.addEventListener('start', () => { this.touched = true })
    player.on_change(() => this.show_time())
    on_resize(this.frame, () => this.resize())
    addEventListener('beforeprint', () => {
      this.render()
      this.print.src = this.canvas.toDataURL('image/png')
    })
    this.canvas.addEventListener('keydown', (event) => this.key(event))
  }

  private give_up() {
    this.failure = 'no WebGL'
    const picture = this.report.pictures.find((p) => p.sceneView)
    this.frame.replaceChildren(el('p', { class: 'no-webgl' },
      'This browser has no WebGL, so the stock cannot be turned here.' +
      (picture ? ' The picture shows it as the program saw it.' : '')),
    ...(picture ? [el('img', { src: picture.src, alt: picture.caption })] : []))
  }

  private make_tools(): HTMLElement {
    const choice = (legend: string, entries: [string, string][], chosen: string, act: (v: string) => void) =>
      el('fieldset', { class: 'segments' }, el('legend', { class: 'sr' }, legend),
        ...entries.map(([value, text]) => el('label', {}, el('input', { type: 'radio', name: legend, value,
          checked: value === chosen, onchange: () => act(value) }), el('span', {}, text))))
    const range = (text: string, value: number, act: (v: number) => void) => {
      const input = el('input', { type: 'range', min: 0, max: 1, step: 0.01, value })
      input.addEventListener('input', () => act(Number(input.value)))
      return el('label', { class: 'range' }, text, input)
    }
    const check = (text: string, on: boolean, act: (v: boolean) => void) => {
      const input = el('input', { type: 'checkbox', checked: on })
      input.addEventListener('change', () => act(input.checked))
      return el('label', { class: 'check' }, input, text)
    }
    const section = range('', this.clip_share, (v) => { this.clip_share = v; this.cut_open() })
    section.hidden = true
    section.querySelector('input')!.setAttribute('aria-label', 'place of the section')
    const view = (name: string, direction: () => THREE.Vector3) =>
      el('button', { type: 'button', class: 'quiet', 'aria-label': `Look: ${name}`,
        onclick: () => this.look(direction()) }, name)
    return el('div', { class: 'scene-tools screen-only' },
      this.has_stock && el('div', { class: 'row' },
        choice('stock', [['before', 'Before'], ['now', 'As cut'], ['after', 'After']], 'now',
          (v) => { this.stage = v as Stage; this.show_time() }),
        range('Opacity', 1, (v) => { this.opacity = v; this.set_opacity() })),
      el('div', { class: 'row' },
        check('Path', true, (v) => { this.path_on = v; this.show_path(); this.draw_soon() }),
        this.cutter && check('Cutter', true, (v) => { if (this.cutter) this.cutter.visible = v; this.draw_soon() }),
        this.has_stock && check(`Cut surface by ${this.report.scene?.valueName ?? 'value'}`, true,
          (v) => { this.uniforms.mapping.value = v ? 1 : 0; this.colour_floor(); this.draw_soon() }),
        this.has_values && check(`Bone by ${this.report.scene!.meshValueName}`, true,
          (v) => { this.uniforms.tinting.value = v ? 1 : 0; this.draw_legend(); this.draw_soon() })),
      this.has_stock && el('div', { class: 'row' },
        choice('section', [['-1', 'Whole'], ['0', 'Section x'], ['1', 'y'], ['2', 'z']], '-1',
          (v) => { this.clip_axis = Number(v); section.hidden = this.clip_axis < 0; this.cut_open() }),
        section),
      el('div', { class: 'row' },
        view('Oblique', () => this.oblique()), view('Along the tool', () => this.tool_axis()),
        view('x', () => new THREE.Vector3(1, 0, 0)), view('y', () => new THREE.Vector3(0, -1, 0)),
        view('z', () => new THREE.Vector3(0, 0, 1))))
  }

  private path_on = true
  private touched = false
  private direction = new THREE.Vector3()

  private key(event: KeyboardEvent) {
    const turns: Record<string, [number, number]> = {
      ArrowLeft: [-0.12, 0], ArrowRight: [0.12, 0], ArrowUp: [0, -0.12], ArrowDown: [0, 0.12] }
    const offset = this.camera.position.clone().sub(this.controls.target)
    if (event.key === '+' || event.key === '-') offset.multiplyScalar(event.key === '+' ? 0.9 : 1.1)
    else if (turns[event.key]) {
      const s = new THREE.Spherical().setFromVector3(new THREE.Vector3(offset.x, offset.z, -offset.y))
      s.theta += turns[event.key][0]
      s.phi = Math.min(Math.max(s.phi + turns[event.key][1], 0.02), Math.PI - 0.02)
      const v = new THREE.Vector3().setFromSpherical(s)
      offset.set(v.x, -v.z, v.y)
    } else return
    event.preventDefault()
    this.camera.position.copy(this.controls.target).add(offset)
    this.controls.update()
    this.draw_soon()
  }

  private mesh(mesh: Mesh, reach: Numbers | undefined, part: 'before' | 'after', run: Run): THREE.Mesh {
    const count = mesh.position[0].length
    const position = new Float32Array(3 * count)
    for (let i = 0; i < count; ++i) for (let a = 0; a < 3; ++a) position[3 * i + a] = mesh.position[a][i]
    const reached = new Float32Array(count)
    const mapped = new Float32Array(3 * count)
    const tint = new Float32Array(3 * count)
    const [low, high] = this.densities
    for (let i = 0; i < count; ++i) {
      const at = reach ? reach[i] : NaN
      reached[i] = Number.isNaN(at) ? this.never : at
      if (mesh.value) tint.set(mapped_colour((mesh.value[i] - low) / (high - low), bone), 3 * i)
      if (part === 'after' && !Number.isNaN(at) && run.path) {
        const value = run.path.value[index_at(run.path.time, at)]
        mapped.set(mapped_colour(value / this.largest), 3 * i)
      }
    }
    const geometry = new THREE.BufferGeometry()
    geometry.setAttribute('position', new THREE.BufferAttribute(position, 3))
    geometry.setAttribute('reach', new THREE.BufferAttribute(reached, 1))
    geometry.setAttribute('mapped', new THREE.BufferAttribute(mapped, 3))
    geometry.setAttribute('tint', new THREE.BufferAttribute(tint, 3))
    geometry.setIndex(new THREE.BufferAttribute(mesh.corners as Uint32Array, 1))
    geometry.computeVertexNormals()
    geometry.computeBoundingBox()
    const material = stock_material(part, part === 'before' ? this.uniforms : this.after_uniforms)
    return new THREE.Mesh(geometry, material)
  }

  private largest = 1
  private densities: [number, number] = [0, 1]
  private never = 1

  show(run: Run) {
    if (this.failure) return
    this.run = run
    // "Never" lies behind the end of the run, but not so far that it tears the triangles between
    // what the cutter reached and what it did not.
    const [start, end] = run.path ? [run.path.time[0], run.path.time[run.path.time.length - 1]] : [0, 0]
    this.never = end + (end - start) + 1
    this.uniforms.cut.value = 0.5 * (this.never + end)
    // One scale for all runs, so that their colours can be compared.
    this.largest = Math.max(1e-9, this.report.scene?.valueLimit ?? 0)
    for (const { path } of this.report.runs)
      for (const value of path?.value ?? []) if (value > this.largest) this.largest = value
    this.densities = this.range_of_values()
    for (const child of [...this.content.children]) {
      this.content.remove(child)
      const drawn = child as THREE.Mesh
      drawn.geometry.dispose()
      ;(drawn.material as THREE.Material).dispose()
    }
    const first = this.box.isEmpty()
    this.before = this.after = null
    const before = run.before ?? this.report.scene?.before
    if (before) {
      this.before = this.mesh(before, run.beforeReach, 'before', run)
      this.content.add(this.before)
    }
    if (run.after) {
      this.after = this.mesh(run.after, run.afterReach, 'after', run)
      this.content.add(this.after)
    }
    this.add_path(run)
    this.box.makeEmpty()
    for (const part of [this.before, this.after]) if (part) this.box.union(part.geometry.boundingBox!)
    if (this.box.isEmpty() && run.path)
      for (let i = 0; i < run.path.time.length; ++i) this.box.expandByPoint(place_mm(run.path, i))
    const size = this.box.getSize(new THREE.Vector3())
    this.caption.replaceChildren(`${reading(size.x)} × ${reading(size.y)} × ${reading(size.z)} mm. `,
      el('span', { class: 'screen-only' },
        'Drag to turn, wheel to zoom, right button to move; arrow keys and + − when the view has the focus.'))
    this.canvas.setAttribute('aria-label',
      `${run.name}: ${this.has_stock ? 'stock' : 'path'} of ${reading(size.x)} by ${reading(size.y)} by ${reading(size.z)} mm, ` +
      `path coloured by ${this.report.scene?.valueName}`)
    this.draw_legend()
    this.set_opacity()
    this.cut_open()
    if (first) this.direction = this.oblique()
    this.resize()
    this.show_time()
  }

  /** Of the values of all surfaces, in round numbers. */
  private range_of_values(): [number, number] {
    let low = Infinity
    let high = -Infinity
    for (const mesh of [this.report.scene?.before, ...this.report.runs.flatMap((r) => [r.before, r.after])])
      for (const value of mesh?.value ?? []) {
        if (value < low) low = value
        if (value > high) high = value
      }
    if (!(low < high)) return [low - 1, low + 1]
    const step = 10 ** Math.floor(Math.log10(high - low))
    return [step * Math.floor(low / step), step * Math.ceil(high / step)]
  }

  private add_path(run: Run) {
    this.line = this.trail = this.floor = null
    const path = run.path
    if (!path || path.time.length < 2) return
    const places: number[] = []
    const colours: number[] = []
    for (let i = 1; i < path.time.length; ++i) {
      const colour = mapped_colour(path.value[i] > 0 ? path.value[i] / this.largest : NaN)  // air is grey
      const from = Number.isNaN(path.value[i]) ? i : i - 1  // a jump is a line of no length
      for (const k of [from, i]) places.push(path.tip[0][k], path.tip[1][k], path.tip[2][k])
      colours.push(...colour, ...colour)
    }
    const make = (width: number, opacity: number, in_front: boolean) => {
      const geometry = new LineSegmentsGeometry()
      geometry.setPositions(places)
      geometry.setColors(colours)
      const material = new LineMaterial({ vertexColors: true, linewidth: width, transparent: true,
        opacity, depthTest: !in_front, depthWrite: false })
      const line = new LineSegments2(geometry, material)
      line.renderOrder = in_front ? 3 : 2
      this.content.add(line)
      return line
    }
    this.line = make(1.5, 0.3, true)
    this.trail = make(4, 1, false)
    if (this.report.scene?.cutter) {
      this.floor = swept_floor(path, this.report.scene.cutter, this.largest)
      this.content.add(this.floor.mesh)
      this.colour_floor()
    }
  }

  /** Through the bone the path is seen only where the bone is open or clear: elsewhere it would seem
   *  to float before it. */
  private show_path() {
    if (this.trail) this.trail.visible = this.path_on
    if (this.line) this.line.visible = this.path_on && (!this.has_stock || this.opacity < 1 || this.clip_axis >= 0)
  }

  private colour_floor() {
    const material = this.floor?.mesh.material as THREE.MeshLambertMaterial | undefined
    if (!material) return
    material.vertexColors = this.uniforms.mapping.value > 0
    material.color.copy(material.vertexColors ? new THREE.Color(1, 1, 1) : this.uniforms.fresh.value)
    material.needsUpdate = true
  }

  private draw_legend() {
    const scene = this.report.scene!
    const bar = (name: string, map: ColourMap, low: number, high: number, limit?: number) => {
      const field = el('div', { class: 'gradient' })
      field.style.background = gradient(map, 'to right')
      const mark = (value: number, text: string, kind = '') => {
        const place = el('span', { class: `mark ${kind}` }, text)
        place.style.left = `${(100 * (value - low)) / (high - low)}%`
        field.append(place)
      }
      for (const value of [low, (low + high) / 2, high]) mark(value, reading(value))
      if (limit && limit < 0.98 * high) mark(limit, `limit ${reading(limit)}`, 'limit')
      return el('div', {}, el('div', { class: 'name' }, name), field)
    }
    const bars: HTMLElement[] = []
    if (this.run?.path)
      bars.push(bar(`${scene.valueName}, ${written(scene.valueUnit)}`, viridis, 0, this.largest, scene.valueLimit))
    if (this.uniforms.tinting.value > 0)
      bars.push(bar(`${scene.meshValueName}, ${written(scene.meshValueUnit)}`, bone, ...this.densities))
    this.legend.replaceChildren(...bars)
    this.legend.hidden = bars.length === 0
  }

  private set_opacity() {
    for (const part of [this.before, this.after]) {
      if (!part) continue
      const material = part.material as THREE.MeshLambertMaterial
      material.transparent = this.opacity < 1
      material.opacity = this.opacity
      part.visible = this.opacity > 0.01
    }
    this.show_path()
    this.show_time()
  }

  private cut_open() {
    this.show_path()
    const a = this.clip_axis
    this.renderer.clippingPlanes = []
    if (a >= 0) {
      const low = this.box.min.getComponent(a)
      const high = this.box.max.getComponent(a)
      // Keep the part behind, as seen from the oblique view.
      const sign = a === 1 ? 1 : -1
      this.clip.normal.set(0, 0, 0).setComponent(a, sign)
      this.clip.constant = -sign * (low + (high - low) * (a === 1 ? 1 - this.clip_share : this.clip_share))
    }
    const planes = a >= 0 ? [this.clip] : []
    for (const part of [this.before, this.after])
      if (part) (part.material as THREE.Material).clippingPlanes = planes
    // Beside the bone the cutter leaves no floor.
    const { min, max } = this.box
    const sides = [0, 1, 2].flatMap((k) => [1, -1].map((sign) => new THREE.Plane(
      new THREE.Vector3().setComponent(k, sign), sign > 0 ? -min.getComponent(k) : max.getComponent(k))))
    if (this.floor) (this.floor.mesh.material as THREE.Material).clippingPlanes = [...planes, ...sides]
    this.renderer.localClippingEnabled = true
    this.draw_soon()
  }

  private tool_axis(): THREE.Vector3 {
    return this.run?.path ? axis_of(this.run.path, 0) : new THREE.Vector3(0, 0, 1)
  }

  /** From the side on which the tool is and cuts, so that the cut is in sight. */
  private oblique(): THREE.Vector3 {
    const axis = this.tool_axis()
    const aside = new THREE.Vector3(0.59, -0.81, 0.1)
    const cut = new THREE.Box3()
    const path = this.run?.path
    for (let i = 0; i < (path?.time.length ?? 0); ++i)
      if (path!.value[i] > 0) cut.expandByPoint(place_mm(path!, i))
    const size = this.box.getSize(new THREE.Vector3())
    const off = cut.getCenter(new THREE.Vector3()).sub(this.box.getCenter(new THREE.Vector3()))
    if (!cut.isEmpty() && Math.abs(off.x) > 0.2 * size.x) aside.x = Math.sign(off.x) * Math.abs(aside.x)
    if (!cut.isEmpty() && Math.abs(off.y) > 0.2 * size.y) aside.y = Math.sign(off.y) * Math.abs(aside.y)
    aside.addScaledVector(axis, -aside.dot(axis)).normalize()
    return axis.multiplyScalar(0.75).addScaledVector(aside, 0.85)
  }

  /** Looks from a direction so that the whole stock is just seen. */
  private look(direction: THREE.Vector3) {
    const centre = this.box.getCenter(new THREE.Vector3())
    const towards = direction.normalize()
    this.direction.copy(towards)
    this.touched = false
    // The view cannot be level with its own axis: lean a little.
    if (Math.abs(towards.z) > 0.9995) towards.y -= 0.002
    const right = new THREE.Vector3().crossVectors(this.camera.up, towards).normalize()
    const up = new THREE.Vector3().crossVectors(towards, right)
    const high = Math.tan((Math.PI / 360) * this.camera.fov)
    const wide = high * this.camera.aspect
    let distance = 1
    for (let i = 0; i < 8; ++i) {
      const corner = new THREE.Vector3(...[0, 1, 2].map((a) =>
        (i >> a) & 1 ? this.box.max.getComponent(a) : this.box.min.getComponent(a))).sub(centre)
      const out = Math.max(Math.abs(corner.dot(right)) / wide, Math.abs(corner.dot(up)) / high)
      distance = Math.max(distance, 1.08 * out + corner.dot(towards))
    }
    this.controls.target.copy(centre)
    this.camera.position.copy(centre).addScaledVector(towards, distance)
    this.camera.near = distance / 100
    this.camera.far = distance * 10
    this.camera.updateProjectionMatrix()
    this.controls.update()
    this.draw_soon()
  }

  private show_time() {
    const run = this.run
    if (!run || this.failure) return
    const at = this.player.shown
    // At the end only the finished surface is shown, which knows all that was cut.
    const finished = this.after !== null && (this.stage === 'after' || (this.stage === 'now' && at >= this.player.end))
    const none = -1e9
    this.uniforms.time.value = this.stage === 'before' || !this.after ? none : finished ? this.never + 1 : at
    this.after_uniforms.time.value = this.stage === 'before' ? none : finished ? this.never + 1 : at
    if (this.before) this.before.visible = !finished && this.opacity > 0.01
    if (this.after) this.after.visible = this.stage !== 'before' && this.opacity > 0.01
    const path = run.path
    if (path && path.time.length > 1) {
      const i = index_at(path.time, at)
      const done = this.stage === 'after' ? path.time.length - 1 : i
      if (this.trail) this.trail.geometry.instanceCount = done
      if (this.floor) {
        this.floor.mesh.visible = this.stage !== 'before' && !finished && this.opacity > 0.01
        this.floor.mesh.geometry.setDrawRange(0, this.floor.first_index[done])
      }
      if (this.cutter) {
        const k = Math.min(i + 1, path.time.length - 1)
        const span = path.time[k] - path.time[i]
        const share = span > 0 ? Math.min(Math.max((at - path.time[i]) / span, 0), 1) : 0
        this.cutter.position.copy(place_mm(path, i)).lerp(place_mm(path, k), share)
        this.cutter.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), axis_of(path, i))
        if (this.player.playing) this.cutter.rotateZ(-at * 9)
      }
    }
    this.draw_soon()
  }

  private resize() {
    const { clientWidth: width, clientHeight: height } = this.frame
    if (width < 20 || height < 20) return
    this.renderer.setSize(width, height, false)
    this.camera.aspect = width / height
    this.camera.updateProjectionMatrix()
    if (!this.touched && !this.box.isEmpty()) this.look(this.direction.clone())
    this.draw_soon()
  }

  recolour() { this.draw_soon() }

  private draw_soon() {
    if (this.waiting || this.failure) return
    this.waiting = true
    requestAnimationFrame(() => {
      this.waiting = false
      this.render()
    })
  }

  private render() {
    const dark = current_theme() === 'dark'
    this.uniforms.bone.value.set(dark ? 0xd8ccb4 : 0xe9dfc9)
    const size = this.renderer.getSize(new THREE.Vector2())
    this.renderer.setViewport(0, 0, size.x, size.y)
    this.renderer.clear()
    this.renderer.render(this.world, this.camera)
    const corner = 72
    this.triad_camera.position.copy(this.camera.position).sub(this.controls.target).setLength(5)
    this.triad_camera.up.copy(this.camera.up)
    this.triad_camera.lookAt(0, 0, 0)
    this.renderer.setViewport(4, 4, corner, corner)
    this.renderer.clearDepth()
    this.renderer.render(this.triad, this.triad_camera)
  }

  /** For the tests of the page: what is being drawn. */
  drawn(): { stage: Stage; cutter: number[]; camera: number[] } {
    return { stage: this.stage, cutter: this.cutter?.position.toArray() ?? [],
      camera: this.camera.position.toArray() }
  }
}
