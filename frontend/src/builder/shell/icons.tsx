/** Icons as paths in a square of 20. */

import type { ReactElement } from "react";

const PATHS: Readonly<Record<string, string>> = {
  undo: "M7 4 3 8l4 4M3 8h9a5 5 0 0 1 0 10H9",
  redo: "m13 4 4 4-4 4M17 8H8a5 5 0 0 0 0 10h3",
  play: "M6 4v12l10-6z",
  save: "M4 3h10l3 3v11H3V4zM6 3v5h7V3M6 17v-6h8v6",
  open: "M2 16V4h5l2 2h8v3M2 16l3-7h14l-3 7z",
  file: "M5 2h7l4 4v12H4V3zM12 2v4h4",
  plus: "M10 4v12M4 10h12",
  menu: "M3 5h14M3 10h14M3 15h14",
  sum: "M15 5V3H5l5 7-5 7h10v-2",
  chart: "M3 3v14h14M6 13l3-4 3 2 4-6",
  help: "M7 7a3 3 0 1 1 4.2 2.7c-.8.4-1.2 1-1.2 1.8v.5M10 15.5v.1",
  theme: "M10 3a7 7 0 1 0 0 14zM10 3a7 7 0 0 1 0 14",
  arrange: "M3 4h5v4H3zM12 3h5v4h-5zM12 13h5v4h-5zM8 6h2v9h2M10 5h2",
  fit: "M3 7V3h4M13 3h4v4M17 13v4h-4M7 17H3v-4",
  close: "m5 5 10 10M15 5 5 15",
  wide: "M11 3h6v6M17 3l-7 7M9 17H3v-6M3 17l7-7",
  trash: "M4 6h12M8 6V3h4v3M6 6l1 11h6l1-11",
  check: "m4 10 4 4 8-9",
  warning: "M10 3 2 17h16zM10 8v4M10 14.5v.1",
  error: "M10 2a8 8 0 1 0 0 16 8 8 0 0 0 0-16M10 6v5M10 13.5v.1",
  note: "M10 2a8 8 0 1 0 0 16 8 8 0 0 0 0-16M10 9v5M10 6v.1",
  down: "m5 8 5 5 5-5",
  right: "m8 5 5 5-5 5",
  folder: "M2 16V4h5l2 2h9v10z",
  copy: "M7 7h10v10H7zM13 7V3H3v10h4",
  body: "M3 6h14v8H3z",
  ground: "M3 8h14M4 12l3-4M9 12l3-4M14 12l3-4M10 3v5",
  joint: "M10 6a4 4 0 1 0 0 8 4 4 0 0 0 0-8M2 10h4M14 10h4",
  revolute: "M15.5 7A6 6 0 1 0 16 10M16 3v4.5h-4.5M10 9.2a.8.8 0 1 0 0 1.6.8.8 0 0 0 0-1.6",
  prismatic: "M2 10h16M5 7l-3 3 3 3M15 7l3 3-3 3M7 6h6v8H7z",
  weld: "M4 4v12M16 4v12M4 7h12M4 13h12M7 7l3 6M12 7l3 6",
  spherical: "M10 5a5 5 0 1 0 0 10 5 5 0 0 0 0-10M3 14c0-7 2-11 7-11M15 10c-2 2-8 2-10 0",
  cylindrical: "M6 4h8v12H6zM2 10h3M15 10h3M8 2c3-1 6 0 6 2M6 16c1 2 4 3 7 2",
  universal: "M3 3v5c0 3 3 4 7 4s7-1 7-4V3M6 17v-5M14 17v-5M3 10h14",
  screw: "M5 3h10M6 7l8-2M6 11l8-2M6 15l8-2M10 15v3",
  planar: "M2 13 6 6h12l-4 7zM10 9.500v.1M7 16h8M13 14l2 2-2 2",
  gimbal: "M10 3a7 7 0 1 0 0 14 7 7 0 0 0 0-14M10 6a4 4 0 0 0 0 8 4 4 0 0 0 0-8M2 10h4M14 10h4",
  free: "M10 2v16M2 10h16M8 4l2-2 2 2M8 16l2 2 2-2M4 8l-2 2 2 2M16 8l2 2-2 2",
  cartesian: "M5 3v12h12M5 15l6-6M3 5l2-2 2 2M15 13l2 2-2 2",
  rectangular: "M5 3v12h12M3 5l2-2 2 2M15 13l2 2-2 2",
  bushing: "M3 5h14v10H3zM6 8h8v4H6z",
  spring: "M2 10h2l1.500-4 3 8 3-8 3 8 1.500-4h2",
  torsion_spring: "M10 10c0-1 1.500-1 1.500.3 0 2-3.500 2-3.500-.6C8 6 14 6 14 10c0 5-9 5-9-.5C5 3 17 3 17 10v7",
  force: "M2 10h14M11 5l5 5-5 5",
  torque: "M4 14A7 7 0 1 1 16 13M16 17v-4.500h-4.500",
  constraint: "M7 13a3.500 3.500 0 0 1 0-5l2-2a3.500 3.500 0 0 1 5 5M13 7a3.500 3.500 0 0 1 0 5l-2 2a3.500 3.500 0 0 1-5-5",
  gear: "M10 6a4 4 0 1 0 0 8 4 4 0 0 0 0-8M10 2v3M10 15v3M2 10h3M15 10h3M4.500 4.500l2 2M13.500 13.500l2 2M15.500 4.500l-2 2M6.500 13.500l-2 2",
  belt: "M6 6a4 4 0 1 0 0 8h8a4 4 0 1 0 0-8zM6 9.500v1M14 9.500v1",
  rolling: "M10 3a6 6 0 1 0 0 12 6 6 0 0 0 0-12M10 9V5M2 16h16",
  distance: "M3 6v8M17 6v8M3 10h14M6 7l-3 3 3 3M14 7l3 3-3 3",
  equation: "M4 8h12M4 12h12",
  signal: "M2 10c2-8 4-8 6 0s4 8 6 0 3-6 4-6",
  block: "M5 5h10v10H5zM1.500 10H5M15 10h3.500",
  inputs: "M2 10h9M8 6l4 4-4 4M15 4v12",
  include: "M3 7l7-4 7 4v7l-7 4-7-4zM3 7l7 4 7-4M10 11v7",
  table: "M3 4h14v12H3zM3 8h14M3 12h14M9 4v12",
  pid: "M5 3h10v14H5zM1.500 10H5M15 10h3.500M8 13V7h2a1.700 1.700 0 0 1 0 3.400H8",
  dc_motor: "M10 4a6 6 0 1 0 0 12 6 6 0 0 0 0-12M1.500 10H4M16 10h2.500M7.500 12.500v-5l2.500 3 2.500-3v5",
  delay: "M3 4v12h14M3 14h5V7h9M5 10h3",
  first_order: "M3 4v12h14M3 16c2-7 4-9 13-9",
  rate_limit: "M3 4v12h14M4 15l8-8h5",
  state_space: "M6 3H3v14h3M14 3h3v14h-3M7 8h6M7 12h6",
  transfer_function: "M4 10h12M8 6.500h4M7 13.500h6",
};

export function Icon({ name, fallback = "joint", size = 18 }: { name: string; fallback?: string; size?: number }): ReactElement {
  const path = PATHS[name] ?? PATHS[fallback] ?? PATHS["joint"]!;
  return (
    <svg className="icon" width={size} height={size} viewBox="0 0 20 20" aria-hidden="true">
      <path d={path} />
    </svg>
  );
}
