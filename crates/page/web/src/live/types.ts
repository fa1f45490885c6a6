// The answers of the module, as `crates/edit` writes them.

export interface Label { from: number; to: number; text: string; line: number }
export interface Fault {
  code: string;
  is_error: boolean;
  message: string;
  labels: Label[];
  notes: string[];
  help: string | null;
}
export interface Control {
  path: string;
  kind: string;
  name: string;
  text: string;
  is_guess: boolean;
  number?: number;
  unit?: string;
  range?: [number, number, number];
  /** True if the model states the range. */
  is_stated?: boolean;
}
export interface Element { section: string; name: string; keys: { path: string; key: string; text: string }[]; more: string[] }
export interface Joint { name: string; kind: string; bodies: [number, number]; value: number | null; is_driven: boolean }
/** A force that stays as it is: its point in the frame of its body, and its vector in the world's axes or the body's, N. */
export interface Force { body: number; at: [number, number, number]; vector: [number, number, number]; follows: boolean }
export interface Point { name: string; body: number; at: [number, number, number] }
export interface State {
  text: string;
  can_undo: boolean;
  can_redo: boolean;
  is_current: boolean;
  is_whole: boolean;
  faults: Fault[];
  controls: Control[] | null;
  elements: Element[] | null;
  scene?: Scene;
  joints?: Joint[];
  points?: Point[];
  forces?: Force[];
  fault?: Fault;
}
export interface Attached { body: number; position: [number, number, number] }
export interface Shape { body: number; role: number; front: boolean; kind: string; lines: number[][]; radius: number }
export interface Marker { name: string; kind: string; joint: number | null; at: Attached }
export interface Scene {
  planar: boolean;
  bodies: string[];
  shapes: Shape[];
  spans: { ends: Attached[] }[];
  cords: { places: { at: Attached; radius: number }[] }[];
  markers: Marker[];
  pin: number;
  themes: Record<string, Theme>;
}
export interface Theme { colors: { background: number[]; text: number[]; faint: number[]; palette: number[][]; force: number[]; velocity: number[] }; paints: unknown[]; sections: unknown[] }
export interface Transmission { at: string; degrees: number }
export interface Dragged { distance: number; limit: string | null; transmissions?: Transmission[] }
export interface Moved {
  n_frames?: number;
  curves?: { name: string; unit: string }[];
  forces?: Acting[];
  scene?: Scene;
  faults: Fault[];
  is_derived?: boolean;
}
/** A wrench on a body, by what it comes from; of a joint its number, and whether the body is its second. */
export interface Acting { body: number; kind: string; name: string; joint: number | null; is_second: boolean }
export interface Freedoms {
  gruebler?: number;
  mobility?: number;
  redundant_conditions?: number;
  redundant_joints?: string[];
  coordinates?: string[];
  drives?: number;
  faults?: Fault[];
}
/** A symbol of the equations: its MathML, the bodies that it belongs to, and the value of a parameter. */
export interface Symbol { html: string; name: string; value?: number; bodies: number[] }
export interface Equations { sections?: { title: string; html: string }[]; symbols?: Symbol[]; remark?: string | null; faults?: Fault[] }
export interface Table { title: string; heads: string[]; rows: string[][] }
export interface Limits { tables?: Table[]; beyond?: string[]; refused?: string }
export interface Ways { assemblies?: { number: number; name: string }[]; held?: string[]; faults?: Fault[] }
export type Edit = { edit: string } & Record<string, unknown>;
export interface Answer<T> { json: T; numbers: Float64Array }
export type Pixel = [number, number];
/** A place in the world, m. */
export type World = [number, number, number];
