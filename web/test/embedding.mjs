// Puts the viewer into pages as people do, disturbs it, and writes down what becomes of it: node embedding.mjs ADDRESS
// EXPORTED FOLDER, with ADDRESS serving a small PEM and EXPORTED the index.html of an exported page. Judging is
// tests/view/test_embedding.py's part.

import { writeFile } from "node:fs/promises";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { loseDevice, withPage } from "./browser.mjs";

const [address, exported, folder] = process.argv.slice(2);
const seen = { complaints: [] };

// A long page that allows nothing inline and has styles for everything.
const LONG = `<!doctype html><link rel="icon" href="data:,"><link rel="stylesheet" href="long.css"><script type="module" src="reflet-viewer.js"></script>
  <div></div><reflet-viewer src="scene/scene.gltf"></reflet-viewer><div></div>`;
const LONG_CSS = `* { margin: 0; padding: 0; letter-spacing: 4px; text-transform: uppercase }
  div { height: 2000px } reflet-viewer { width: 240px; height: 200px }`;

await withPage(
  async (page) => {
    const viewer = (use, argument) =>
      page.evaluate(`(${use})(document.querySelector("reflet-viewer"), ${JSON.stringify(argument)})`);
    const frame = () => viewer(async (element) => Array.from((await element.rawFrame(16, 12, 4)).radiance));
    const state = async () => ({
      scroll: await page.evaluate(() => scrollY),
      ...(await viewer((element) => element.viewpoint)),
    });
    const canvasSize = async () => {
      await page.evaluate(() => new Promise(requestAnimationFrame).then(() => new Promise(requestAnimationFrame)));
      await viewer((element) => element.settled());
      return viewer((element) => {
        const { width, height } = element.shadowRoot.querySelector("canvas");
        return [width, height];
      });
    };
    const notice = () =>
      viewer(async (element) => {
        const said = await element.ready.then(
          () => "",
          (error) => error.message,
        );
        const shown = element.shadowRoot.querySelector(".notice[role=alert]");
        return shown && !shown.hidden && shown.textContent === said ? said : `not shown: ${said}`;
      });

    // Opened from the disk.
    await page.goto(pathToFileURL(exported).href);
    await page.waitForFunction(() => getComputedStyle(document.querySelector("p")).opacity === "1");
    seen.fromDisk = await page.evaluate(() => document.body.textContent);
    await page.screenshot({ path: join(folder, "from-disk.png") });

    page.on("console", (message) => {
      const text = `${message.text()} ${message.location().url}`;
      if (["error", "warning"].includes(message.type())) seen.complaints.push(text);
    });
    page.on("pageerror", (error) => seen.complaints.push(error.message));

    // In the middle of a long page.
    const headers = {
      "content-security-policy":
        "default-src 'self'; img-src data:; require-trusted-types-for 'script'; trusted-types reflet-viewer",
    };
    await page.route("**/long.html", (route) => route.fulfill({ body: LONG, contentType: "text/html", headers }));
    await page.route("**/long.css", (route) => route.fulfill({ body: LONG_CSS, contentType: "text/css" }));
    await page.goto(`${address}long.html`);
    await viewer((element) => element.ready);
    seen.styles = await viewer((element) => {
      const { letterSpacing, textTransform, position } = getComputedStyle(element.shadowRoot.querySelector(".hint"));
      return { letterSpacing, textTransform, position };
    });
    await viewer((element) => {
      window.hints = [];
      const hint = element.shadowRoot.querySelector(".hint");
      const note = () => hint.classList.contains("shown") && window.hints.push(hint.textContent);
      new MutationObserver(note).observe(hint, { attributeFilter: ["class"] });
    });
    await page.evaluate(() => scrollTo(0, 1900));
    const { x, y, width, height } = await page.locator("canvas").boundingBox();
    const [middleX, middleY] = [x + width / 2, y + height / 2];
    const scrolled = (by) => page.waitForFunction((value) => scrollY === value, 1900 + by);
    const zoomed = (before) =>
      page.waitForFunction((value) => document.querySelector("reflet-viewer").viewpoint.distance !== value, before);
    await page.mouse.move(middleX, middleY);
    seen.atFirst = await state();
    await page.mouse.wheel(0, 5);
    await scrolled(5);
    seen.afterWheel = await state();
    await page.keyboard.down("Control");
    await page.mouse.wheel(0, 25);
    await page.keyboard.up("Control");
    await zoomed(seen.afterWheel.distance);
    seen.afterCtrlWheel = await state();
    await page.mouse.click(middleX, middleY);
    await page.mouse.wheel(0, 25);
    await zoomed(seen.afterCtrlWheel.distance);
    seen.afterClickAndWheel = await state();
    await viewer((element) => element.shadowRoot.activeElement.blur());

    // Fingers: up, to the right, and two that move down and together.
    const touch = await page.context().newCDPSession(page);
    const send = (type, ...touchPoints) => touch.send("Input.dispatchTouchEvent", { type, touchPoints });
    const swipe = async (place) => {
      await send("touchStart", ...place(0));
      for (let k = 1; k <= 5; k++) await send("touchMove", ...place(k));
      await page.waitForTimeout(200); // at rest before it is lifted: no fling
      await send("touchEnd");
    };
    await swipe((k) => [{ x: middleX, y: middleY - 10 * k }]);
    seen.afterSwipeUp = await state();
    await swipe((k) => [{ x: middleX + 10 * k, y: middleY + k }]);
    seen.afterSwipeRight = await state();
    const apart = (k) => 50 - 5 * k;
    await swipe((k) => [-1, 1].map((side, id) => ({ x: middleX + side * apart(k), y: middleY + 4 * k, id })));
    seen.afterTwoFingers = await state();
    seen.hints = await page.evaluate(() => window.hints);

    // Let go over a menu: no pointer is up, but no button is down.
    seen.afterLostButton = await viewer((element) => {
      const canvas = element.shadowRoot.querySelector("canvas");
      canvas.setPointerCapture = () => {};
      const at = (clientX, buttons) => ({ pointerId: 77, pointerType: "mouse", clientX, clientY: 0, buttons });
      canvas.dispatchEvent(new PointerEvent("pointerdown", at(0, 1)));
      canvas.dispatchEvent(new PointerEvent("pointermove", at(50, 0)));
      canvas.dispatchEvent(new PointerEvent("pointermove", at(90, 0)));
      return element.viewpoint;
    });

    // Its place and the screen's pixels change.
    seen.size = await canvasSize();
    await touch.send("Emulation.setDeviceMetricsOverride", {
      ...{ width: 490, height: 360, mobile: false, deviceScaleFactor: 0.5 }, // Chromium tells of both together alone
    });
    seen.sizeAtTwiceTheRatio = await canvasSize();
    const restyle = (text) => page.evaluate((css) => document.styleSheets[0].insertRule(css, 2), text);
    await restyle("reflet-viewer { display: none !important }");
    seen.sizeHidden = await canvasSize();
    await page.evaluate(() => document.styleSheets[0].deleteRule(2));
    await restyle("reflet-viewer { width: 200px !important }");
    seen.sizeShownAgain = await canvasSize();

    // The graphics process ends.
    await viewer((element) => {
      element.configure({ exposure: 3, blend: false });
      element.viewpoint = { azimuth_deg: 61.25, elevation_deg: 15, distance: 2.5 };
    });
    seen.beforeLoss = { frame: await frame(), ...(await state()) };
    await viewer((element) => {
      window.panel = element.shadowRoot.querySelector(".panel");
    });
    const complaints = [...seen.complaints]; // before the browser tells of its crash, and of missing files
    await loseDevice(page);
    seen.afterLoss = { frame: await frame(), ...(await state()) };
    seen.samePanel = await viewer((element) => element.shadowRoot.querySelector(".panel") === window.panel);

    // Removed, put back; two at once; another scene.
    await page.evaluate(() => {
      window.destroyed = 0;
      const { destroy } = GPUDevice.prototype;
      GPUDevice.prototype.destroy = function () {
        window.destroyed += 1;
        destroy.call(this);
      };
    });
    seen.removed = await viewer(async (element) => {
      element.remove();
      const said = await element.settled().catch((error) => error.message);
      document.body.prepend(element);
      await element.settled();
      const { viewpoint, settings } = element;
      return { said, destroyed: window.destroyed, viewpoint, exposure: settings.exposure };
    });
    seen.frameAgain = await frame();
    seen.second = await viewer(async (element) => {
      const second = document.createElement("reflet-viewer");
      second.setAttribute("src", "scene/scene.gltf");
      document.body.append(second);
      await second.ready;
      second.configure({ blend: false });
      second.viewpoint = element.viewpoint;
      const radiance = Array.from((await second.rawFrame(16, 12, 4)).radiance);
      second.remove();
      return radiance;
    });
    // Devices that are lost as soon as they are there.
    await page.evaluate(() => {
      window.toLose = 0;
      const { requestDevice } = GPUAdapter.prototype;
      GPUAdapter.prototype.requestDevice = async function (description) {
        const device = await requestDevice.call(this, description);
        if (window.toLose-- > 0) {
          device.destroy();
          window.destroyed -= 1;
          Object.defineProperty(device, "lost", { value: Promise.resolve({ reason: "unknown" }) });
        }
        return device;
      };
    });
    seen.other = await viewer(async (element) => {
      const before = element.ready;
      element.setAttribute("src", "scene/scene.gltf?other");
      const fresh = element.ready !== before;
      element.setAttribute("src", "scene/nowhere.gltf"); // before the other is there
      const said = await element.ready.catch((error) => error.message);
      window.toLose = 2;
      element.setAttribute("src", "scene/scene.gltf");
      await element.settled();
      const notice = element.shadowRoot.querySelector(".notice").hidden;
      const panels = element.shadowRoot.querySelectorAll(".panel").length;
      return {
        fresh,
        said,
        notice,
        panels,
        viewpoint: element.viewpoint,
        destroyed: window.destroyed,
        toLose: window.toLose,
      };
    });
    seen.lostAlways = await viewer(async (element) => {
      window.toLose = 9;
      element.setAttribute("src", "scene/scene.gltf?lost");
      return element.settled().catch((error) => error.message);
    });
    seen.toLose = await page.evaluate(() => window.toLose);

    // No WebGPU, for each cause; in a frame of another page.
    await page.evaluate(() => {
      GPU.prototype.requestAdapter = async () => null;
    });
    await viewer((element) => element.setAttribute("src", "scene/scene.gltf?no-adapter"));
    seen.noAdapter = await notice();
    const proxy = "http://lab.example:8000/user/you/proxy/80/";
    await page.route(`${proxy}**`, async (route) => {
      const url = route.request().url().replace(proxy, address);
      const response = await route.fetch({ url }).catch(() => undefined); // the page may be closed meanwhile
      if (response) await route.fulfill({ response }).catch(() => undefined);
    });
    await page.goto(proxy);
    seen.insecure = await notice();
    await page.locator(".notice").selectText(); // as one does who copies what it says
    seen.selected = await page.evaluate(() => getSelection().toString());
    seen.captured = [await page.locator("canvas.captured").count()];
    const framed = '<!doctype html><iframe src="index.html"></iframe>';
    await page.route("**/framed.html", (route) => route.fulfill({ body: framed, contentType: "text/html" }));
    await page.goto(`${proxy}framed.html`);
    await page.frameLocator("iframe").locator(".notice[role=alert]").waitFor();
    seen.captured.push(await page.frameLocator("iframe").locator("canvas.captured").count());
    seen.complaints = complaints;
  },
  { width: 480, height: 360, scale: 0.25 },
);

await writeFile(join(folder, "seen.json"), JSON.stringify(seen));
