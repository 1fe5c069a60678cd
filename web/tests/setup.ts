/** Before the tests of each file: the page's texts, which it loads before it shows anything. */
import { chooseLanguage } from "../src/texts";

await chooseLanguage("en");
