// Runs a program of a folder's modules in MicroPython: node micropython.mjs PROGRAM.py, beside the package that `micropython.sh` installs.
import { readFileSync, readdirSync } from "node:fs";
import { loadMicroPython } from "@micropython/micropython-webassembly-pyscript/micropython.mjs";

const python = await loadMicroPython({ heapsize: 64 * 1024 * 1024, linebuffer: true, stdout: (line) => console.log(line) });
python.FS.mkdir("/modules");
for (const file of readdirSync(".").filter((file) => file.endsWith(".py"))) {
    python.FS.writeFile(`/modules/${file}`, readFileSync(file));
}
python.runPython("import sys\nsys.path.append('/modules')");
python.runPython(readFileSync(process.argv[2], "utf8"));
