within WiperDrive;
package Tests "Small models that state a law and measure how far they are from it"
end Tests;
