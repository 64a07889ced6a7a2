// Uses the viewer as a person would and writes down what it shows: node viewer.mjs ADDRESS ORBIT_ADDRESS FOLDER. ADDRESS serves
// a small PEM, ORBIT_ADDRESS one of many viewpoints. Judging is tests/view/test_viewer.py's part.

import { withViewer } from "./viewer-page.mjs";

const [address, orbitAddress, folder] = process.argv.slice(2);
const screen = [120, 90];

await withViewer(folder, async ({ page, viewer, viewpoint, keep, picture, seen }) => {
  await page.goto(address);
  await viewer((element) => element.ready);
  await keep("screen", "at rest", screen);
  await keep("home", 16);
  await keep("home-at-rest", "at rest");
  await keep("home-in-motion", "in motion");
  await keep("home-multisampled", "multisampled");

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
  // The canvas alone: the picture at rest, and the maps laid flat.
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
  await page.getByRole("combobox", { name: "Geometry" }).selectOption("infinite_sphere");
  await keep("infinite-sphere", 4);

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
});
