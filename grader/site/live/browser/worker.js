// Runs Python in a Web Worker, so that the page stays usable and an endless loop can be ended.
//
// Messages to the worker: {python, library} once, with two addresses, then {source, quietly} for each
// cell. Messages from it: {kind: "loading", loaded}, {kind: "ready"}, {kind: "failed", text}, and the
// messages of guest/kernel.py, of which {kind: "done", ok} is the last of a cell.
import { ConsoleStdout, Directory, File, OpenFile, PreopenDirectory, WASI } from "@bjorn3/browser_wasi_shim";

const LIBRARY = "/usr/local/lib";
const NO_HOST = -1; // the guest's functions for calls to the host answer that there is none

let python;
let loaded = 0;

// Returns a stream of the decompressed bytes of a file.
const load = async (address) => {
  const response = await fetch(address);
  if (!response.ok) throw new Error(`${address}: ${response.status} ${response.statusText}`);
  const counted = response.body.pipeThrough(new TransformStream({
    transform(chunk, controller) {
      loaded += chunk.length;
      postMessage({ kind: "loading", loaded });
      controller.enqueue(chunk);
    },
  }));
  return counted.pipeThrough(new DecompressionStream("gzip"));
};

// Returns a folder of the guest with the files of a tar archive.
const unpacked = (bytes) => {
  const root = new Map();
  const decoder = new TextDecoder();
  const text = (start, length) => decoder.decode(bytes.subarray(start, start + length)).replace(/\0.*$/s, "");
  for (let start = 0; start + 512 <= bytes.length && bytes[start]; ) {
    const size = parseInt(text(start + 124, 12), 8);
    const prefix = text(start + 345, 155);
    const parts = (prefix ? `${prefix}/` : "").concat(text(start, 100)).split("/");
    const name = parts.pop();
    let folder = root;
    for (const part of parts) {
      if (!folder.has(part)) folder.set(part, new Directory(new Map()));
      folder = folder.get(part).contents;
    }
    folder.set(name, new File(bytes.subarray(start + 512, start + 512 + size)));
    start += 512 + Math.ceil(size / 512) * 512;
  }
  return root;
};

// A console that is not a folder, which the guest asks each open file at its start.
class Channel extends ConsoleStdout {
  fd_prestat_get() { return { ret: 8, prestat: null }; }
}

const start = async ({ python: binary, library }) => {
  const compiling = load(binary).then((stream) => WebAssembly.compileStreaming(
    new Response(stream, { headers: { "Content-Type": "application/wasm" } })));
  const archive = await new Response(await load(library)).arrayBuffer();
  const files = unpacked(new Uint8Array(archive));
  const below = (path) => path.split("/").reduce((folder, part) => folder.get(part).contents, files);
  const say = (name) => ConsoleStdout.lineBuffered((line) => postMessage({ kind: "stream", name, text: `${line}\n` }));
  const folders = [
    new PreopenDirectory(LIBRARY, below("usr/local/lib")),
    new PreopenDirectory(`${LIBRARY}/python315.zip/matplotlib/mpl-data`, below("data/matplotlib/mpl-data")),
    new PreopenDirectory("/", new Map([
      ["packages", files.get("packages")], ["tmp", new Directory(new Map())], ["home", new Directory(new Map())],
    ])),
  ];
  const decoder = new TextDecoder();
  let rest = "";
  const channel = new Channel((data) => {
    const lines = (rest + decoder.decode(data, { stream: true })).split("\n");
    rest = lines.pop();
    for (const line of lines) postMessage(JSON.parse(line));
  });
  const descriptors = [new OpenFile(new File([])), say("stdout"), say("stderr"), ...folders, channel];
  const environment = ["HOME=/home", "TMPDIR=/tmp", "PYTHONTZPATH=", "IPYTHONDIR=/tmp", "MPLCONFIGDIR=/tmp",
    "MPLBACKEND=module://matplotlib_inline.backend_inline", `CHANNEL=${descriptors.length - 1}`];
  const wasi = new WASI(["/usr/local/bin/python.wasm"], environment, descriptors, { debug: false });
  const instance = await WebAssembly.instantiate(await compiling, {
    wasi_snapshot_preview1: wasi.wasiImport,
    host: { call: () => NO_HOST },
  });
  wasi.initialize(instance);
  python = instance.exports;
  if (turn(`import sys; sys.path.append("/packages"); import kernel`)) throw new Error("The kernel did not start.");
};

// Runs code in the interpreter's module __main__, and returns 0 if it raises nothing.
const turn = (code) => {
  const data = new TextEncoder().encode(code);
  const place = python.host_alloc(data.length) >>> 0;
  new Uint8Array(python.memory.buffer).set(data, place);
  return python.turn(place, data.length);
};

onmessage = async ({ data }) => {
  try {
    if (data.python) {
      await start(data);
      postMessage({ kind: "ready" });
    } else {
      // A JSON string is also a Python string.
      const cell = `${JSON.stringify(data.source)}, ${data.quietly ? "True" : "False"}`;
      if (turn(`__import__("kernel").run(${cell})`)) throw new Error("Python cannot run this cell.");
    }
  } catch (error) {
    postMessage({ kind: "failed", text: error.message });
  }
};
