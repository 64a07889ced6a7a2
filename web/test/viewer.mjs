// Uses the viewer as a person would and writes down what it shows: node viewer.mjs ADDRESS ORBIT_ADDRESS FOLDER OTHERS.
// ADDRESS serves a small PEM, ORBIT_ADDRESS one of many viewpoints, OTHERS (JSON: by name {address, viewpoint}) PEMs of
// other kinds and where each is seen from. Judging is tests/view/test_viewer.py's part.

import { writeFile } from "node:fs/promises";
import { join } from "node:path";
import { withPage } from "./browser.mjs";

const [address, orbitAddress, folder, others] = process.argv.slice(2);
const browser = { width: 480, height: 360, scale: 0.25 }; // few pixels on the screen: they are drawn by software
const screen = [120, 90];
const small = [64, 48];
const seen = { complaints: [], frames: {} };

await withPage(async (page) => {
  page.on("console", (message) => {
    if (["error", "warning"].includes(message.type())) seen.complaints.push(message.text());
  });
  page.on("pageerror", (error) => seen.complaints.push(error.message));

  const viewer = (use, argument) =>
    page.evaluate(`(${use})(document.querySelector("reflet-viewer"), ${JSON.stringify(argument)})`);
  const viewpoint = () => viewer((element) => element.viewpoint);
  const keep = async (name, samples, [width, height] = small) => {
    const radiance = await viewer(
      async (element, [w, h, s]) => Array.from((await element.rawFrame(w, h, s)).radiance),
      [width, height, samples],
    );
    await writeFile(join(folder, `${name}.f32`), new Float32Array(radiance));
    seen.frames[name] = { width, height, viewpoint: await viewpoint() };
  };

  await page.goto(address);
  await viewer((element) => element.ready);
  await keep("screen", "at rest", screen);
  await keep("home", 16);
  await keep("home-at-rest", "at rest");
  await keep("home-in-motion", "in motion");
  await keep("home-multisampled", "multisampled");

  // The canvas alone: the picture at rest, and the maps laid flat.
  const picture = async (name, settings) => {
    await page.addStyleTag({ content: "body { background: none }" });
    const show = (visibility) =>
      viewer((element, value) => {
        for (const part of element.shadowRoot.querySelectorAll(".toggle, .panel")) part.style.visibility = value;
      }, visibility);
    await show("hidden");
    await viewer((element, changed) => element.configure(changed), settings);
    await viewer((element) => element.settled());
    await page.screenshot({ path: join(folder, `${name}.png`) });
    await viewer((element) => element.configure({ view: "picture" }));
    await show("");
  };
  seen.commands = await viewer(async (element) => {
    let count = 0;
    const submit = GPUQueue.prototype.submit;
    GPUQueue.prototype.submit = function (...given) {
      count += 1;
      return submit.apply(this, given);
    };
    element.viewpoint = {}; // where it is: the picture is drawn anew
    await element.settled();
    const settling = count;
    await new Promise((resolve) => setTimeout(resolve, 500));
    GPUQueue.prototype.submit = submit;
    return { settling, afterwards: count - settling };
  });
  await picture("picture", {});
  await picture("maps", { view: "maps", layer: 1 });

  // By mouse, wheel and keyboard.
  const { x, y, width: w, height: h } = await page.locator("canvas").boundingBox();
  await page.mouse.move(x + w / 2, y + h / 2);
  await page.mouse.down();
  await page.mouse.move(x + w / 2 - 4, y + h / 2 + 20, { steps: 2 });
  await page.mouse.up();
  await keep("dragged", 16);
  await page.mouse.wheel(0, 100);
  await page.waitForFunction((before) => document.querySelector("reflet-viewer").viewpoint.distance > before, 2);
  await keep("zoomed", 4);
  await page.locator("canvas").focus();
  await page.keyboard.press("ArrowRight");
  seen.afterArrow = await viewpoint();
  await page.keyboard.press("Home");
  seen.afterHome = await viewpoint();

  // Two fingers, 150 pixels apart, then 100.
  const touch = await page.context().newCDPSession(page);
  const fingers = (apart) => [-1, 1].map((side) => ({ x: x + w / 2 + (side * apart) / 2, y: y + h / 2 }));
  await touch.send("Input.dispatchTouchEvent", { type: "touchStart", touchPoints: fingers(150) });
  await touch.send("Input.dispatchTouchEvent", { type: "touchMove", touchPoints: fingers(100) });
  await touch.send("Input.dispatchTouchEvent", { type: "touchEnd", touchPoints: [] });
  await page.waitForFunction((before) => document.querySelector("reflet-viewer").viewpoint.distance > before, 2.9);
  seen.afterPinch = await viewpoint();
  await page.keyboard.press("Home");

  // By the panel, found as a person finds things: by their names.
  await page.getByRole("button", { name: "Settings" }).click();
  await viewer((element) => {
    element.viewpoint = { azimuth_deg: 61.25 };
  });
  await keep("blended", 4);
  await page.getByRole("radio", { name: "Nearest" }).check();
  await keep("nearest", 4);
  await page.getByRole("checkbox", { name: "Local" }).uncheck();
  await keep("without-local", 4);
  await page.getByRole("checkbox", { name: "Fresnel" }).uncheck();
  await page.getByRole("checkbox", { name: "Diffuse" }).uncheck();
  await keep("distant-alone", 4);
  await page.getByRole("combobox", { name: "Geometry" }).selectOption("infinite_sphere");
  await keep("infinite-sphere", 4);

  // Other kinds of PEMs.
  for (const [name, { address: where, viewpoint: point }] of Object.entries(JSON.parse(others))) {
    await page.goto(where);
    if (name === "static") {
      seen.settledSize = await viewer(async (element) => {
        await element.ready;
        await element.settled();
        const { width, height } = element.shadowRoot.querySelector("canvas");
        return [width, height];
      });
    }
    await viewer((element) => element.ready);
    await viewer((element, to) => {
      element.viewpoint = to;
    }, point);
    await keep(name, 4);
    if (["gazing_ball", "shells", "traced"].includes(name)) await keep(`${name}-multisampled`, "multisampled");
    if (name === "traced") {
      await page.getByRole("button", { name: "Settings" }).click();
      await page.getByRole("radio", { name: "By origin" }).check();
      await keep("traced-origin", 4);
      await page.getByRole("radio", { name: "As seen" }).check();
      await page.getByRole("checkbox", { name: "Local" }).uncheck();
      await keep("traced-without", 4);
    }
    if (name === "shells") {
      await picture("alpha", { view: "maps", layer: 0, mapShows: "alpha" });
      await picture("distance", { view: "maps", layer: 0, mapShows: "distance" });
      await picture("base", { view: "maps", layer: 1, mapShows: "distance", mapOf: "base" }); // it has no relief
      await page.getByRole("button", { name: "Settings" }).click();
      await page.getByRole("checkbox", { name: "balls 0" }).uncheck();
      await keep("shells-far", 4);
      await page.getByRole("radio", { name: "By origin" }).check();
      await keep("shells-far-origin", 4);
      await page.getByRole("radio", { name: "As seen" }).check();
      await page.getByRole("checkbox", { name: "balls 0" }).check();
      await page.getByRole("combobox", { name: "Geometry" }).selectOption("infinite sphere, all shells");
      await keep("shells-infinite-sphere", 4);
    }
  }

  // Many viewpoints: all the way round, while maps come and go.
  await page.goto(orbitAddress);
  const residents = async () => {
    await viewer((element) => element.rawFrame(4, 3, 1)); // waits for the maps of the view
    return viewer((element) => element.shadowRoot.querySelector(".status").textContent);
  };
  seen.resident = [await residents()];
  for (let azimuth = 1; azimuth < 360; azimuth += 15) {
    await viewer((element, value) => {
      element.viewpoint = { azimuth_deg: value };
    }, azimuth);
    seen.resident.push(await residents());
  }
  await keep("far-round", 4);

  // What cannot be shown is said in a sentence.
  const notice = (src) =>
    page.evaluate(async (where) => {
      const element = document.createElement("reflet-viewer");
      element.setAttribute("src", where);
      document.body.replaceChildren(element);
      const said = await element.ready.then(
        () => "",
        (error) => error.message,
      );
      const shown = element.shadowRoot.querySelector(".notice[role=alert]");
      return shown && !shown.hidden && shown.textContent === said ? said : `not shown: ${said}`;
    }, src);
  const complaints = [...seen.complaints];
  seen.notices = { missing: await notice("scene/nowhere.gltf"), foreign: await notice("reflet-viewer.js") };
  await page.evaluate(() => Object.defineProperty(navigator, "gpu", { value: undefined, configurable: true }));
  seen.notices.noWebGpu = await notice("scene/scene.gltf");
  seen.complaints = complaints; // the missing file just now is in the console, as it should be
}, browser);

await writeFile(join(folder, "seen.json"), JSON.stringify(seen));
