// The renderer's own WGSL text, put together by the rule of `reflet/shaders/link.py`: a line `#import name` stands for
// the text of `name.wgsl`, each file once.

const files = import.meta.glob<string>("../../../../src/reflet/shaders/*.wgsl", {
  query: "?raw",
  import: "default",
  eager: true,
});

/** The complete WGSL text of a program, such as "picture". */
export function link(program: string): string {
  const included = new Set<string>();
  const expand = (text: string): string =>
    text.replace(/^#import ([a-z_]+)\n/gm, (_line, name: string) => {
      if (included.has(name)) return "";
      included.add(name);
      return `${expand(read(name))}\n`;
    });
  return expand(read(program));
}

function read(name: string): string {
  const text = files[`../../../../src/reflet/shaders/${name}.wgsl`];
  if (text === undefined) throw new Error(`There is no shader file ${name}.wgsl.`);
  return text;
}
