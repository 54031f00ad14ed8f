// The golden data, read from JavaScript: strict ajv compiles the schemas, and every case obeys its.
// npm install ajv@8 && node tests/golden/read.js "$(longball golden path)"
const Ajv = require("ajv/dist/2020");
const fs = require("fs");
const path = require("path");

const folder = process.argv[2];
const read = (name) => fs.readFileSync(path.join(folder, name), "utf8");
const validator = (name) =>
  new Ajv({ strict: true }).compile(JSON.parse(read(`${name}.schema.json`)));
const faults = [];

function check(name, validate, data) {
  if (!validate(data)) faults.push(`${name}: ${JSON.stringify(validate.errors[0])}`);
}

const header = JSON.parse(read("header.json"));
check("header", validator("header"), header);
check("probability", validator("probability"), JSON.parse(read("probability.json")));
const ofCase = validator("case");
let count = 0;
for (const [family, { file, cases }] of Object.entries(header.families)) {
  const lines = read(file).trim().split("\n");
  if (lines.length !== cases) faults.push(`${family}: ${lines.length} cases, not ${cases}`);
  for (const line of lines) {
    const one = JSON.parse(line);
    check(one.id, ofCase, one);
    for (const [name, quantity] of Object.entries(one.quantities))
      if (!Number.isFinite(quantity.double)) faults.push(`${one.id}: ${name}`);
    count++;
  }
}
console.log(`${count} cases, ${faults.length} faults`);
faults.slice(0, 20).forEach((fault) => console.log(fault));
process.exit(faults.length || !count ? 1 : 0);
