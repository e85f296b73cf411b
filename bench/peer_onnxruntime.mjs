// node peer_onnxruntime.mjs MODULES DIR GRAPH: ONNX Runtime of the folder MODULES on DIR/GRAPH and the window in DIR/vectors.*, as
// network_frames.cpp is for ours: "peak N" in KiB after the first frame, then n frames for each n on a line of the input, in ms of the
// process's processors. One thread, one operator at a time. GRAPH "none": no model, what the runtime itself takes.
import {closeSync, openSync, readFileSync, readSync} from 'node:fs';
import {createRequire} from 'node:module';
import path from 'node:path';
import readline from 'node:readline';

const ARRAYS = {uint8: Uint8Array, uint16: Uint16Array, int64: BigInt64Array};
const INPUTS = ['focus', 'context', 'half', 'used'];

const [modules, folder, graph] = process.argv.slice(2);
const ort = createRequire(path.resolve(modules, 'x.js'))('onnxruntime-node');

function reader() { // only what is asked for: the file holds every tensor of the integer model
  const places = JSON.parse(readFileSync(path.join(folder, 'vectors.json'), 'utf8'));
  const file = openSync(path.join(folder, 'vectors.bin'), 'r');
  const read = (name) => {
    const {type, shape, offset} = places[name];
    const data = new ARRAYS[type](shape.reduce((a, b) => a * b, 1));
    readSync(file, new Uint8Array(data.buffer), 0, data.byteLength, offset);
    return {type, shape, data};
  };
  return {read, close: () => closeSync(file)};
}

function peak() { // of /proc: node's own figure is of the process that it was started from
  return Number(/VmHWM:\s*(\d+)/.exec(readFileSync('/proc/self/status', 'utf8'))[1]);
}

let frame = async () => null;
if (graph !== 'none') {
  const session = await ort.InferenceSession.create(path.join(folder, graph), {
    intraOpNumThreads: 1, interOpNumThreads: 1, executionMode: 'sequential', graphOptimizationLevel: 'all', logSeverityLevel: 3});
  const {read, close} = reader();
  const inputs = {};
  for (const name of INPUTS) {
    const {type, shape, data} = read(`in_${name}`);
    inputs[name] = new ort.Tensor(type, data, shape);
  }
  frame = () => session.run(inputs);
  const {index} = await frame();
  console.log(`peak ${peak()}`);
  const ours = read('index').data;
  close();
  const mean = index.data.reduce((sum, value, i) => sum + Math.abs(value - ours[i] / 256), 0) / ours.length;
  console.log(`apart ${mean.toFixed(4)}`);
} else {
  console.log(`peak ${peak()}`);
  console.log('apart 0');
}

for await (const line of readline.createInterface({input: process.stdin})) {
  const times = [];
  for (let n = Number(line); n > 0; --n) {
    const start = process.cpuUsage();
    await frame();
    const {user, system} = process.cpuUsage(start);
    times.push(((user + system) / 1000).toFixed(4));
  }
  console.log(times.join(' '));
}
