// Loading this script makes <reflet-viewer> known to the page.

import { RefletViewer } from "./page/viewer";

customElements.define("reflet-viewer", RefletViewer);

declare global {
  interface HTMLElementTagNameMap {
    "reflet-viewer": RefletViewer;
  }
}

export { RefletViewer };
