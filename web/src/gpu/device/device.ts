// The graphics device of the browser.

/** Opens a device; rejects with one sentence where there is none. */
export async function openDevice(): Promise<GPUDevice> {
  if (!navigator.gpu) {
    const why = window.isSecureContext ? "this browser does not offer it" : "browsers offer it over https only";
    throw new Error(`This picture is drawn with WebGPU, and ${why}; try a current Chrome, Edge, Safari or Firefox.`);
  }
  const adapter = await navigator.gpu.requestAdapter({ powerPreference: "high-performance" });
  if (adapter === null) {
    throw new Error("This picture is drawn with WebGPU, and this browser found no graphics adapter for it.");
  }
  const { maxTextureDimension2D, maxBufferSize, maxStorageBufferBindingSize } = adapter.limits;
  return adapter.requestDevice({
    requiredLimits: { maxTextureDimension2D, maxBufferSize, maxStorageBufferBindingSize },
  });
}
