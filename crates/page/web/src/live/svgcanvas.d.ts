/** A context that writes down what is drawn on it. */
declare module 'svgcanvas' {
  export class Context {
    constructor(width: number, height: number);
    getSerializedSvg(fixNamedEntities: boolean): string;
  }
}
