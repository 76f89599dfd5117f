// SPDX-License-Identifier: BSD-3-Clause
// What stands in the 3-D view: materials of the stock, the cutter, the trail that it leaves.
import * as THREE from 'three'
import { colour_at, type ColourMap, viridis } from './colours'
import type { Cutter, Path } from './data'

/** Surfaces of stock: drawn only where the cutter has come by (or not yet), with a flat inside so
 *  that an open surface reads as a cut through solid bone. */
export function stock_material(part: 'before' | 'after', uniforms: Record<string, THREE.IUniform>) {
  const material = new THREE.MeshLambertMaterial({ color: 0xffffff, side: THREE.DoubleSide })
  material.onBeforeCompile = (shader) => {
    Object.assign(shader.uniforms, uniforms)
    shader.vertexShader = shader.vertexShader
      .replace('#include <common>', `#include <common>
        attribute float reach; attribute vec3 mapped; attribute vec3 tint;
        centroid varying float vReach; varying vec3 vMapped; varying vec3 vTint;`)
      .replace('#include <begin_vertex>', `#include <begin_vertex>
        vReach = reach; vMapped = mapped; vTint = tint;`)
    const hide = part === 'before' ? 'vReach <= time' : 'vReach > time'
    shader.fragmentShader = shader.fragmentShader
      .replace('#include <common>', `#include <common>
        centroid varying float vReach; varying vec3 vMapped; varying vec3 vTint;
        uniform float time, cut, mapping, tinting; uniform vec3 bone, fresh, inside;`)
      .replace('#include <color_fragment>', `#include <color_fragment>
        if (${hide}) discard;
        bool is_cut = ${part === 'after' ? 'vReach < cut' : 'false'};
        vec3 plain = tinting > 0.5 ? vTint : is_cut ? fresh : bone;
        diffuseColor.rgb = is_cut && mapping > 0.5 ? vMapped : plain;`)
      .replace('#include <opaque_fragment>', `#include <opaque_fragment>
        if (!gl_FrontFacing) gl_FragColor = vec4(inside, gl_FragColor.a);`)
  }
  // Two programs: three would take the source of this function for all that matters.
  material.customProgramCacheKey = () => part
  return material
}

/** The colour of a value as three wants it: linear light. */
export function mapped_colour(share: number, map: ColourMap = viridis): [number, number, number] {
  const colour = new THREE.Color()
  if (Number.isFinite(share)) colour.setRGB(...colour_at(map, share), THREE.SRGBColorSpace)
  else colour.set(0x8c9399)
  return [colour.r, colour.g, colour.b]
}

export function place_mm(path: Path, i: number): THREE.Vector3 {
  return new THREE.Vector3(path.tip[0][i], path.tip[1][i], path.tip[2][i])
}

export function axis_of(path: Path, i: number): THREE.Vector3 {
  const k = path.axis[0].length > 1 ? i : 0
  return new THREE.Vector3(path.axis[0][k], path.axis[1][k], path.axis[2][k]).normalize()
}

export function cutter_model(cutter: Cutter): THREE.Group {
  const group = new THREE.Group()
  const length = cutter.outline[cutter.outline.length - 1][1]
  const shank = Math.max(length, 6 * cutter.radius)
  const profile = [new THREE.Vector2(0, 0), ...cutter.outline.map(([r, z]) => new THREE.Vector2(r, z)),
    new THREE.Vector2(cutter.radius * 0.92, length + 0.05 * cutter.radius),
    new THREE.Vector2(cutter.radius * 0.92, length + shank), new THREE.Vector2(0, length + shank)]
  const body = new THREE.Mesh(new THREE.LatheGeometry(profile, 40),
    new THREE.MeshPhongMaterial({ color: 0x9fb0bd, specular: 0x8899a5, shininess: 60,
      transparent: true, opacity: 0.62, side: THREE.DoubleSide }))
  body.rotation.x = Math.PI / 2
  group.add(body)
  const edge = new THREE.LineBasicMaterial({ color: 0x23313d })
  for (let j = 0; j < Math.max(cutter.flutes, 1); ++j) {
    const points = cutter.outline.map(([radius, z, lag]) => {
      // Angles run clockwise seen from the spindle (src/osteomill/cutting/cutter.hpp).
      const theta = (2 * Math.PI * j) / cutter.flutes - lag
      return new THREE.Vector3(Math.sin(theta), Math.cos(theta), 0).multiplyScalar(1.004 * radius).setZ(z)
    })
    group.add(new THREE.Line(new THREE.BufferGeometry().setFromPoints(points), edge))
  }
  return group
}

/** The bottom of the cutter from side to side: [across, above the tip]. */
function profile_of(cutter: Cutter): [number, number][] {
  const half: [number, number][] = []
  for (const [radius, height] of cutter.outline) {
    half.push([radius, height])
    if (radius > 0.999 * cutter.radius) break
  }
  // At most a dozen pieces; a flat end is one.
  const kept = half.filter((_, i) => i === half.length - 1 || i % Math.ceil(half.length / 6) === 0)
  return [...kept.toReversed().map(([r, z]): [number, number] => [-r, z]), ...kept]
}

/** What the bottom of the cutter sweeps over, coloured by the value: the floor of the cut while it is
 *  being cut. Moves along the axis and through air leave nothing. `first_index[i]` is the number of
 *  corners that are drawn when place i has been reached. */
export function swept_floor(path: Path, cutter: Cutter, largest: number):
  { mesh: THREE.Mesh; first_index: Uint32Array } {
  const profile = profile_of(cutter)
  const position: number[] = []
  const normal: number[] = []
  const colour: number[] = []
  const corners: number[] = []
  const count = path.time.length
  const first_index = new Uint32Array(count)
  const across = new THREE.Vector3()
  for (let i = 1; i < count; ++i) {
    first_index[i] = corners.length
    if (!(path.value[i] > 0)) continue
    const axis = axis_of(path, i)
    const from = place_mm(path, i - 1)
    const to = place_mm(path, i)
    const way = to.clone().sub(from)
    across.crossVectors(axis, way)
    if (across.length() < 0.05 * way.length() || way.lengthSq() === 0) continue
    across.normalize()
    const base = position.length / 3
    for (const [side, height] of profile) {
      for (const place of [from, to]) {
        position.push(...place.clone().addScaledVector(across, side).addScaledVector(axis, height).toArray())
        // A sphere's normal seen from within, which is a flat end's for a flat end.
        normal.push(...axis.clone().multiplyScalar(1).addScaledVector(across, -0.6 * side / cutter.radius)
          .normalize().toArray())
        colour.push(...mapped_colour(path.value[i] / largest))
      }
    }
    for (let k = 0; k + 1 < profile.length; ++k) {
      const a = base + 2 * k
      corners.push(a, a + 1, a + 3, a, a + 3, a + 2)
    }
    first_index[i] = corners.length
  }
  const geometry = new THREE.BufferGeometry()
  geometry.setAttribute('position', new THREE.Float32BufferAttribute(position, 3))
  geometry.setAttribute('normal', new THREE.Float32BufferAttribute(normal, 3))
  geometry.setAttribute('color', new THREE.Float32BufferAttribute(colour, 3))
  geometry.setIndex(corners)
  // Where the finished floor lies in the same place, that one wins.
  const mesh = new THREE.Mesh(geometry, new THREE.MeshLambertMaterial({ vertexColors: true,
    side: THREE.DoubleSide, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 4 }))
  return { mesh, first_index }
}
