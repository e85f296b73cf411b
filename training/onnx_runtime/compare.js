// node compare.js DIR: float.onnx and qdq.onnx of egofocus_training.export in ONNX Runtime, against PyTorch's outputs and the
// integer model's in DIR/vectors.*. Needs `npm install --ignore-scripts onnxruntime-node` here or further up.
const fs = require('fs');
const path = require('path');

const ARRAYS = {uint8: Uint8Array, uint16: Uint16Array, int32: Int32Array, int64: BigInt64Array, float32: Float32Array};

function readVectors(folder) {
  const places = JSON.parse(fs.readFileSync(path.join(folder, 'vectors.json'), 'utf8'));
  const bytes = fs.readFileSync(path.join(folder, 'vectors.bin'));
  const vectors = {};
  for (const [name, {type, shape, offset}] of Object.entries(places)) {
    if (!(type in ARRAYS)) throw new Error(`vectors.json: ${name} has the unknown type ${type}`);
    const count = shape.reduce((a, b) => a * b, 1);
    const size = count * ARRAYS[type].BYTES_PER_ELEMENT;
    const copy = bytes.buffer.slice(bytes.byteOffset + offset, bytes.byteOffset + offset + size);
    vectors[name] = {type, shape, data: new ARRAYS[type](copy)};
  }
  return vectors;
}

function difference(ours, theirs, unit) {
  let largest = 0;
  let sum = 0;
  for (let i = 0; i < ours.length; ++i) {
    const d = Math.abs(ours[i] - Number(theirs[i]) * unit);
    largest = Math.max(largest, d);
    sum += d;
  }
  return {largest, mean: sum / ours.length};
}

async function main(folder) {
  const ort = require('onnxruntime-node');
  const vectors = readVectors(folder);
  const result = {};
  for (const graph of ['float', 'qdq']) {
    const session = await ort.InferenceSession.create(path.join(folder, `${graph}.onnx`), {intraOpNumThreads: 1});
    const inputs = {};
    for (const name of ['focus', 'context', 'half', 'used']) {
      const v = vectors[`in_${name}`];
      inputs[name] = new ort.Tensor(v.type, v.data, v.shape);
    }
    const outputs = await session.run(inputs);
    for (const name of ['index', 'confidence'])
      result[`${graph} ${name} against PyTorch`] = difference(outputs[name].data, vectors[`${graph}_${name}`].data, 1);
    if (graph === 'qdq') result['qdq index against the integers'] = difference(outputs.index.data, vectors.index.data, 1 / 256);
  }
  for (const [what, {largest, mean}] of Object.entries(result))
    console.log(`${what.padEnd(34)} largest ${largest.toFixed(6)}  mean ${mean.toFixed(6)}`);
  const off = result['float index against PyTorch'].largest > 0.01 || result['qdq index against PyTorch'].mean > 0.1;
  process.exitCode = off ? 1 : 0;
}

if (process.argv.length !== 3) {
  console.error('usage: node compare.js DIR');
  process.exitCode = 2;
} else {
  main(process.argv[2]).catch((error) => {
    console.error(`error: ${error.message}`);
    process.exitCode = error.code === 'MODULE_NOT_FOUND' ? 3 : 4;
  });
}
