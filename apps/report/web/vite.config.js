// Builds one HTML file with everything in it: scripts, styles, licences. It refers to nothing else.
import { createHash } from 'node:crypto'
import { readFileSync, readdirSync, writeFileSync, mkdirSync } from 'node:fs'
import { join, relative } from 'node:path'
import { defineConfig } from 'vite'

const here = import.meta.dirname
const output = join(here, '..', 'dist')

/** The same sum as apps/report/check_bundle.py takes over the files that make the page. */
function sources() {
  const files = []
  const walk = (folder) => {
    for (const entry of readdirSync(folder, { withFileTypes: true })) {
      if (entry.name === 'node_modules') continue
      const path = join(folder, entry.name)
      if (entry.isDirectory()) walk(path)
      else files.push(relative(here, path))
    }
  }
  walk(here)
  const sum = createHash('sha256')
  for (const file of files.sort()) {
    sum.update(`${file}\n`)
    sum.update(createHash('sha256').update(readFileSync(join(here, file))).digest('hex') + '\n')
  }
  return sum.digest('hex')
}

/** The licences of what is in the page, which ask to be carried with it. */
function licences() {
  return ['three', 'uplot'].map((name) => {
    const folder = join(here, 'node_modules', name)
    const { version } = JSON.parse(readFileSync(join(folder, 'package.json'), 'utf8'))
    return `${name} ${version}\n\n${readFileSync(join(folder, 'LICENSE'), 'utf8').trim()}\n`
  })
}

/** Addresses in messages and comments of libraries: the words stay, no address of the net does.
 *  The names of the SVG and XHTML name spaces only look like addresses and are needed. */
function without_addresses(text) {
  return text.replace(/https?:\/\/(?!www\.w3\.org\/(1999|2000)\/)/g, '')
}

function one_file() {
  return {
    name: 'one-file',
    enforce: 'post',
    generateBundle(_, bundle) {
      const page = bundle['index.html']
      let html = page.source
      for (const [name, part] of Object.entries(bundle)) {
        if (part === page) continue
        const code = part.type === 'chunk' ? part.code : String(part.source)
        if (name.endsWith('.css')) {
          html = html.replace(/<link rel="stylesheet"[^>]*>/, () => `<style>${code}</style>`)
        } else {
          const safe = code.replace(/<\/script/g, '<\\/script').replace(/<!--/g, '<\\!--')
          html = html.replace(/<script type="module"[^>]*><\/script>/, '')
          html = html.replace('<!--script-->', () => `<script type="module">${safe}</script>`)
        }
        delete bundle[name]
      }
      html = html.replace('<!--licences-->', () => licences().join('\n\n').replace(/</g, '&lt;'))
      html = html.replace('%sources%', sources())
      mkdirSync(output, { recursive: true })
      writeFileSync(join(output, 'report.html'), without_addresses(html))
      delete bundle['index.html']
    },
  }
}

export default defineConfig({
  root: here,
  build: {
    target: 'es2022',
    outDir: output,
    emptyOutDir: false,
    modulePreload: false,
    assetsInlineLimit: 1e8,
    chunkSizeWarningLimit: 2000,
    write: true,
  },
  plugins: [one_file()],
})
