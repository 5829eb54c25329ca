// Validates the files given as arguments; prints what is wrong with them and ends with 1 if anything is.
const fs = require('fs');
const path = require('path');
const validator = require('gltf-validator');

// Extensions that the validator does not know, and their textures, which look unused to it.
const IGNORED = [
  'UNSUPPORTED_EXTENSION',
  'UNUSED_OBJECT',
  'IMAGE_NPOT_DIMENSIONS',
  // Tangents are made as the specification asks for, by MikkTSpace.
  'MESH_PRIMITIVE_GENERATED_TANGENT_SPACE',
];

async function main() {
  let failed = 0;
  const files = process.argv.slice(2);
  for (const file of files) {
    const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)), {
      uri: path.basename(file),
      ignoredIssues: IGNORED,
      externalResourceFunction: async (uri) =>
        new Uint8Array(fs.readFileSync(path.resolve(path.dirname(file), decodeURIComponent(uri)))),
    });
    const { numErrors, numWarnings, messages } = report.issues;
    if (numErrors + numWarnings > 0) {
      failed += 1;
      const serious = messages.filter((m) => m.severity < 2);
      serious.slice(0, 10).forEach((m) => console.log(`  ${file}: ${m.pointer || ''} ${m.code}: ${m.message}`));
    }
  }
  console.log(`${files.length} files, ${failed} with errors or warnings`);
  process.exit(failed > 0 ? 1 : 0);
}

main().catch((error) => {
  console.error(error);
  process.exit(1);
});
