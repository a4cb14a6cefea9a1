// The built name of what is loaded where three dimensions are shown.
declare module "./space.js" {
  export { lattice, sphere } from "./space";
}
