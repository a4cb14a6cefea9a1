// Built name of the module for three-dimensional views.
declare module "./space.js" {
  export { lattice, sphere } from "./space";
}
